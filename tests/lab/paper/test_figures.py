"""The data of the figures: what the published figures show, in the units that the axes name."""

from __future__ import annotations

import numpy as np
import pytest

from drivegate_lab.paper.drives import ideal_drive
from drivegate_lab.paper.figures import (
    input_current,
    instantaneous_torque,
    phase_currents,
    search_trajectory,
)
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import house_style


def test_the_reference_stops_at_the_least_current_sum() -> None:
    data = search_trajectory.search_trajectory()
    run = data.reference
    assert run.advance_deg[0] == pytest.approx(58.0, abs=0.5), "the search begins at the initial angle"
    assert run.advance_deg[-1] == pytest.approx(data.optimum_deg, abs=1.5)
    assert run.current_sum_a[-1] == pytest.approx(data.optimum_current_sum_a, rel=0.02)
    assert np.abs(run.speed_error_rpm[-10:]).max() < 5.0, "the speed is held within k1"


def test_the_literal_flowchart_locks_up() -> None:
    data = search_trajectory.search_trajectory()
    run = data.published
    assert run.speed_error_rpm[-1] < -5.0, "the speed is lost"
    assert run.current_reference_a[-1] == pytest.approx(data.current_limit_a), "the regulator is saturated"
    assert run.advance_deg[-1] < data.optimum_deg, "the angle is below the feasible edge"
    assert np.ptp(run.advance_deg[-10:]) < 0.1, "the search is frozen"


def test_the_curve_ends_at_the_feasible_edge() -> None:
    data = search_trajectory.search_trajectory()
    feasible = np.isfinite(data.curve_current_sum_a)
    assert data.curve_advance_deg[feasible].min() == pytest.approx(data.optimum_deg, abs=0.3)
    assert np.nanmin(data.curve_current_sum_a) == pytest.approx(data.optimum_current_sum_a, rel=0.01)
    assert data.optimum_deg == pytest.approx(51.9, abs=0.3)


def test_decision_periods_are_means_over_100_ms() -> None:
    run = search_trajectory.search_trajectory().reference
    np.testing.assert_allclose(np.diff(run.time_s), 0.1)
    assert run.time_s[-1] == pytest.approx(12.0)


def test_torque_ripples_below_the_published_limit() -> None:
    data = instantaneous_torque.torque_cycle()
    assert data.mean_nm == pytest.approx(9.8, rel=1e-6)
    assert 11.5 < data.ripple_percent < 13.0, f"{data.ripple_percent} %"
    assert data.one_sided_ripple_percent < data.ripple_percent
    assert data.torque_nm.max() == pytest.approx(data.highest_nm, rel=1e-4)
    assert data.torque_nm.min() == pytest.approx(data.lowest_nm, rel=1e-4)
    assert data.certified, "the state repeats after one cycle"


def test_torque_repeats_ten_times_in_an_electrical_cycle() -> None:
    data = instantaneous_torque.torque_cycle()
    assert (data.angle_deg[0], data.angle_deg[-1]) == pytest.approx((0.0, 360.0))
    grid = np.linspace(0.0, 36.0, 50)
    first = np.interp(grid, data.angle_deg, data.torque_nm)
    for turn in range(1, 10):
        again = np.interp(grid + 36.0 * turn, data.angle_deg, data.torque_nm)
        np.testing.assert_allclose(again, first, atol=0.01, err_msg=f"after {turn} of 10 parts")


def test_the_optimal_angle_saves_current_but_hardly_power() -> None:
    data = input_current.input_current_sweep()
    assert (data.speed_rpm[0], data.speed_rpm[-1], data.speed_rpm.size) == (550.0, 2000.0, 30)
    assert (data.current_saving_percent > 2.0).all(), "current is saved at every speed"
    assert (data.power_saving_percent > 0.0).all()
    assert (data.power_saving_percent < 0.2 * data.current_saving_percent).all(), "the watts saved are few"
    assert (data.optimal_deg >= data.edge_deg - 1e-3).all(), "an optimal angle is feasible"
    assert (data.initial_deg > data.edge_deg).all(), "the reference's line clears the feasible edge"


def test_the_sweep_is_in_amperes_and_watts() -> None:
    data = input_current.input_current_sweep()
    at = int(np.flatnonzero(data.speed_rpm == 1500.0)[0])
    speed = 1500.0 * RADIANS_PER_RPM
    torque = 1500.0 / speed
    beside = point_at_torque(ideal_drive(), speed, np.radians(58.0), torque)
    assert data.initial_deg[at] == pytest.approx(58.0)
    assert data.initial_current_sum_a[at] == pytest.approx(beside.current_sum)
    assert data.initial_input_w[at] == pytest.approx(beside.input_power)
    assert 1500.0 < data.optimal_input_w[at] < 1600.0, "1.5 kW and some copper loss"


def test_the_published_line_is_out_of_reach_at_first() -> None:
    data = input_current.input_current_sweep()
    unreached = data.speed_rpm[data.published_deg < data.edge_deg]
    assert unreached[0] == 550.0
    assert 1100.0 <= unreached[-1] <= 1200.0, f"out of reach up to {unreached[-1]} rpm"


@pytest.mark.parametrize(
    ("name", "speed_rpm", "advance_deg", "cycle_ms"),
    [("fig9-currents-1200", 1200.0, 40.0, 4.5454), ("fig10-currents-1500", 1500.0, 58.0, 3.6364)],
)
def test_phase_currents_are_those_of_the_published_points(
    name: str, speed_rpm: float, advance_deg: float, cycle_ms: float
) -> None:
    data = phase_currents.phase_currents(name)
    assert (data.speed_rpm, data.advance_deg) == (speed_rpm, advance_deg)
    assert data.time_ms[-1] == pytest.approx(cycle_ms, rel=1e-4)
    assert data.current_a.shape == (5, data.time_ms.size)
    assert data.current_a.max() == pytest.approx(data.current_reference_a + 0.25, abs=0.01), (
        "up to the band's edge"
    )
    shifted = np.interp(data.time_ms[-1] * 0.3, data.time_ms, data.current_a[0])
    following = np.interp(data.time_ms[-1] * 0.4, data.time_ms, data.current_a[1])
    assert following == pytest.approx(shifted, abs=0.05), "phase 2 lags phase 1 by a tenth of a cycle"


def test_currents_fall_the_more_the_faster_the_drive_turns() -> None:
    slow, fast = (phase_currents.phase_currents(name) for name in phase_currents.POINTS)
    assert fast.slope_a_per_ms < 0.0, "the EMF is above the supply at 1500 rpm"
    assert fast.slope_a_per_ms < slow.slope_a_per_ms
    assert slow.peak_emf_v < 48.0 < fast.peak_emf_v


def test_every_axis_has_a_unit() -> None:
    currents = tuple(phase_currents.phase_currents(point) for point in phase_currents.POINTS)
    with house_style():
        figures = (
            search_trajectory.draw(search_trajectory.search_trajectory()),
            instantaneous_torque.draw(instantaneous_torque.torque_cycle()),
            input_current.draw(input_current.input_current_sweep()),
            phase_currents.draw(currents),
        )
    for figure in figures:
        for panel in figure.axes:
            for text in (panel.get_xlabel(), panel.get_ylabel()):
                assert text.endswith(")"), f"the axis '{text}' has no unit"
                assert "(" in text, f"the axis '{text}' has no unit"
