"""The oracle against the paper's angles, plain grids and the steady state itself."""

from __future__ import annotations

from math import isnan, nan, pi, radians

import numpy as np
import pytest
from paper_calibration import MotorConstants, calibration_drive

from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phases import make_phases
from drivegate_models.steady import angle_search
from drivegate_models.steady.angle_search import promising_angles, torque_demand
from drivegate_models.steady.current_search import ReferenceSearch, mean_state
from drivegate_models.steady.oracle import (
    CURRENT_TOLERANCE,
    OUT_OF_REACH,
    ROBUST,
    STATIC,
    current_sum_curve,
    feasible_edge,
    least_current_sum,
    least_input_power,
    point_at_torque,
    reference_for_torque,
)
from drivegate_models.steady.steady_state import steady_state

RPM = pi / 30.0
IDEAL = calibration_drive(MotorConstants(0.339, 2.88e-3, radians(98.0)))
BANDED = IDEAL._replace(hysteresis_band=0.25, core_loss_conductance=3e-3)


def _search(drive: Drive, speed_rpm: float, degrees: float, torque: float) -> ReferenceSearch:
    work, slices = make_phases(drive), make_phases(drive)
    demand = (speed_rpm * RPM, 48.0, radians(degrees), torque, drive.current_limit)
    return reference_for_torque(drive, work, slices, *demand, CURRENT_TOLERANCE, 0.0, False)


@pytest.mark.parametrize(
    ("speed_rpm", "torque", "degrees"),
    [
        (1500, 9.8, 51.9),
        (1200, 11.88, 39.9),
        (550, 1500 / (550 * RPM), 26.0),
        (700, 1500 / (700 * RPM), 33.0),
        (1000, 1500 / (1000 * RPM), 33.0),
        (1400, 1500 / (1400 * RPM), 48.0),
        (2000, 1500 / (2000 * RPM), 58.0),
    ],
)
def test_edges_of_the_calibrated_motor(speed_rpm: float, torque: float, degrees: float) -> None:
    edge = np.degrees(feasible_edge(IDEAL, speed_rpm * RPM, torque))
    assert edge == pytest.approx(degrees, abs=0.4 if degrees % 1 == 0 else 0.06)


@pytest.mark.parametrize("drive", [IDEAL, BANDED], ids=["ideal", "banded"])
def test_edge_separates_what_the_limit_reaches(drive: Drive) -> None:
    speed, torque = 1300 * RPM, 10.5
    edge = feasible_edge(drive, speed, torque)
    inside = steady_state(drive, speed, drive.current_limit, edge).torque
    outside = steady_state(drive, speed, drive.current_limit, edge - radians(2e-4)).torque
    assert outside < torque <= inside


def test_no_advance_is_needed_at_low_speed_and_none_helps_beyond_reach() -> None:
    assert feasible_edge(IDEAL, 300 * RPM, 10.0) == 0.0
    assert isnan(feasible_edge(IDEAL, 1500 * RPM, 20.0))
    assert isnan(feasible_edge(IDEAL, 1500 * RPM, 20.0, static=True))


def test_static_edge_lies_below_the_robust_one() -> None:
    speed, torque = 800 * RPM, 1500 / (800 * RPM)
    static = feasible_edge(IDEAL, speed, torque, static=True)
    assert static < feasible_edge(IDEAL, speed, torque) - radians(2.0)
    assert _search(IDEAL, 800, np.degrees(static) + 0.01, torque).feasibility == STATIC
    assert _search(IDEAL, 800, np.degrees(static) - 0.01, torque).feasibility == OUT_OF_REACH


@pytest.mark.parametrize("drive", [IDEAL, BANDED], ids=["ideal", "banded"])
@pytest.mark.parametrize(
    ("speed_rpm", "degrees", "torque"),
    [(200, 0, 12.0), (600, 30, 20.0), (1000, 35, 14.0), (1500, 52.5, 9.8), (1500, 58, 9.8), (2000, 60, 3.0)],
)
def test_point_has_the_demanded_torque(drive: Drive, speed_rpm: float, degrees: float, torque: float) -> None:
    point = point_at_torque(drive, speed_rpm * RPM, radians(degrees), torque)
    assert point.robust
    assert point.static
    assert point.certified
    assert point.torque == pytest.approx(torque, abs=1e-8)
    assert 0.0 <= point.share <= 1.0
    assert point.reference_low <= point.reference <= point.reference_high < point.reference_low + 2e-9
    balance = torque * speed_rpm * RPM + point.copper_loss + point.device_loss
    # The core loss of a floating phase comes from the shaft, so only a part of it is drawn.
    assert balance - 1e-6 <= point.input_power <= balance + point.core_loss + 1e-6


def test_reference_is_the_least_one() -> None:
    found = _search(IDEAL, 1000, 36, 14.0)
    below = [
        steady_state(IDEAL, 1000 * RPM, reference, radians(36)).torque
        for reference in np.linspace(0.0, found.low - 0.01, 200)
    ]
    assert max(below) < 14.0


def test_jump_across_the_demanded_torque_is_mixed_in_time() -> None:
    speed, advance = 1500 * RPM, radians(52.5)
    point = point_at_torque(BANDED, speed, advance, 9.8)
    low = steady_state(BANDED, speed, point.reference_low, advance)
    high = steady_state(BANDED, speed, point.reference_high, advance)
    assert high.torque - low.torque > 0.4, "this point was chosen because the torque jumps there"
    share = (9.8 - low.torque) / (high.torque - low.torque)
    assert point.share == pytest.approx(share, rel=1e-12)
    mixed = (1.0 - share) * low.current_sum + share * high.current_sum
    assert point.current_sum == pytest.approx(mixed, rel=1e-12)
    assert point.torque_lowest == min(low.torque_lowest, high.torque_lowest)
    assert point.torque_highest == max(low.torque_highest, high.torque_highest)


def test_point_out_of_reach_has_no_values() -> None:
    point = point_at_torque(IDEAL, 1500 * RPM, radians(40), 9.8)
    assert not point.robust
    assert not point.static
    assert all(isnan(value) for value in point[2:17])


def test_torque_below_what_blocked_gates_leave_is_out_of_reach() -> None:
    blocked = steady_state(IDEAL, 1500 * RPM, 0.0, 0.0).torque
    assert blocked < -1.0, "the back-EMF rectifies into the supply at this speed"
    assert _search(IDEAL, 1500, 0, blocked - 0.1).feasibility == OUT_OF_REACH
    # Nothing to hold at standstill torque: the gates stay blocked.
    idle = _search(IDEAL, 300, 0, 0.0)
    assert (idle.feasibility, idle.low, idle.share) == (ROBUST, 0.0, 0.0)


@pytest.mark.parametrize("drive", [IDEAL, BANDED], ids=["ideal", "banded"])
def test_mean_state_agrees_with_the_whole_solution(drive: Drive) -> None:
    work, slices = make_phases(drive), make_phases(drive)
    for speed_rpm, reference, degrees in [(300, 8.0, 0), (1000, 12.0, 35), (1500, 26.0, 58)]:
        means = mean_state(drive, work, slices, speed_rpm * RPM, 48.0, reference, radians(degrees))
        whole = steady_state(drive, speed_rpm * RPM, reference, radians(degrees))
        assert means.torque == pytest.approx(whole.torque, rel=1e-9)
        assert means.current_sum == pytest.approx(whole.current_sum, rel=1e-9)
        drawn = whole.source_power + whole.core_source_power + whole.switching_loss
        assert means.input_power == pytest.approx(drawn, rel=1e-9)


@pytest.mark.parametrize("drive", [IDEAL, BANDED], ids=["ideal", "banded"])
@pytest.mark.parametrize(("speed_rpm", "power"), [(900, 150), (1000, 750), (1100, 1500), (1500, 1539)])
def test_no_angle_of_a_plain_grid_beats_the_optimum(drive: Drive, speed_rpm: float, power: float) -> None:
    speed = speed_rpm * RPM
    torque = power / speed
    curve = current_sum_curve(drive, speed, torque, np.radians(np.arange(0.0, 90.01, 0.25)))
    by_sum = least_current_sum(drive, speed, torque)
    by_power = least_input_power(drive, speed, torque)
    # With a band the curve is rough on a scale finer than the oracle's grid of 0.1 degree.
    slack = 1e-6 if drive.hysteresis_band == 0.0 else 2e-3
    assert by_sum.current_sum <= np.nanmin(curve.current_sum) * (1.0 + slack)
    assert by_power.input_power <= np.nanmin(curve.input_power) * (1.0 + slack)
    assert by_power.input_power <= by_sum.input_power * (1.0 + slack)
    assert by_sum.current_sum <= by_power.current_sum * (1.0 + slack)
    point = point_at_torque(drive, speed, by_sum.advance, torque)
    assert point.robust
    assert point.current_sum == pytest.approx(by_sum.current_sum, rel=1e-9)
    assert point.input_power == pytest.approx(by_sum.input_power, rel=1e-9)
    assert point.reference == pytest.approx(by_sum.reference, rel=1e-9)


def test_least_current_sum_lies_on_the_edge_in_the_constant_power_region() -> None:
    edge = feasible_edge(IDEAL, 1500 * RPM, 9.8)
    optimum = least_current_sum(IDEAL, 1500 * RPM, 9.8)
    assert optimum.advance == pytest.approx(edge, abs=radians(1e-3))
    initial = point_at_torque(IDEAL, 1500 * RPM, radians(58.0), 9.8)
    assert optimum.current_sum < 0.92 * initial.current_sum
    assert optimum.input_power > 0.99 * initial.input_power, "the saving is in the currents, hardly in power"


@pytest.mark.parametrize(
    ("name", "speed_rpm", "power", "band"),
    [
        ("paper-5-phase", 550, 1500, 0.25),
        ("paper-5-phase", 800, 500, 0.25),
        ("paper-5-phase", 800, 100, 0.75),
        ("paper-5-phase", 1300, 1200, 0.1),
        ("star-3-phase", 700, 1500, 0.25),
        ("star-3-phase", 1500, 750, 0.25),
    ],
)
def test_angles_that_are_left_out_cannot_be_the_optimum(
    name: str, speed_rpm: float, power: float, band: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive, speed = load_drive(name).plant()._replace(hysteresis_band=band), speed_rpm * RPM
    demand = torque_demand(drive, speed, power / speed)
    assert len(promising_angles(demand)) < 91, "no angle is left out, so that there is nothing to test"
    short = least_current_sum(drive, speed, power / speed)
    monkeypatch.setattr(angle_search, "promising_angles", lambda _demand: range(91))
    assert short == least_current_sum(drive, speed, power / speed), "the whole grid has another optimum"


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["paper-5-phase", "star-3-phase"])
def test_order_of_costs_needs_no_finer_references(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    drive = load_drive(name).plant()
    points = [(speed, share) for speed in (500.0, 1100.0, 1700.0) for share in (0.3, 0.8)]

    def sums() -> list[float]:
        demands = ((rpm * pi / 30.0, share * min(20.0, 1500.0 / (rpm * pi / 30.0))) for rpm, share in points)
        return [least_current_sum(drive, speed, torque).current_sum for speed, torque in demands]

    quick = sums()
    monkeypatch.setattr(angle_search, "_SEARCH_TOLERANCE", 1e-11)
    assert quick == pytest.approx(sums(), rel=2e-4), "the search takes an angle that costs more than the best"


def test_grid_is_whole_where_the_ideal_regulator_reaches_nothing() -> None:
    demand = torque_demand(BANDED, 1500 * RPM, 30.0)
    assert promising_angles(demand) == list(range(91))


def test_optimum_beyond_reach_is_nan() -> None:
    assert all(isnan(value) for value in least_current_sum(IDEAL, 1500 * RPM, 20.0))
    assert all(isnan(value) for value in least_input_power(IDEAL, 1500 * RPM, 20.0))


def test_curve_marks_angles_below_the_edge() -> None:
    curve = current_sum_curve(IDEAL, 1500 * RPM, 9.8, np.radians([40.0, 51.0, 53.0, 58.0]))
    np.testing.assert_array_equal(curve.feasible, [False, False, True, True])
    np.testing.assert_array_equal(np.isnan(curve.current_sum), ~curve.feasible)
    np.testing.assert_array_equal(np.isnan(curve.input_power), ~curve.feasible)


def test_less_supply_needs_more_advance() -> None:
    nominal = feasible_edge(IDEAL, 1200 * RPM, 9.0)
    assert feasible_edge(IDEAL, 1200 * RPM, 9.0, voltage=43.2) > nominal + radians(1.0)


def test_current_sum_scales_with_the_units() -> None:
    """Twice the voltage, resistance, inductance and back-EMF give the same currents at twice the torque."""
    double = IDEAL._replace(half_supply_voltage=96.0, resistance=0.16, inductance=5.76e-3, emf_constant=0.678)
    once = least_current_sum(IDEAL, 1300 * RPM, 9.0)
    twice = least_current_sum(double, 1300 * RPM, 18.0)
    assert twice.current_sum == pytest.approx(once.current_sum, rel=1e-6)
    assert twice.input_power == pytest.approx(2.0 * once.input_power, rel=1e-6)


@pytest.mark.parametrize(
    ("speed", "torque", "voltage", "words"),
    [
        (0.0, 5.0, None, "speed"),
        (nan, 5.0, None, "speed"),
        (50.0, nan, None, "torque"),
        (50.0, 5.0, 0.0, "voltage"),
    ],
)
def test_unusable_numbers_are_refused(speed: float, torque: float, voltage: float | None, words: str) -> None:
    with pytest.raises(InputError, match=words):
        feasible_edge(IDEAL, speed, torque, voltage)
    with pytest.raises(InputError, match=words):
        point_at_torque(IDEAL, speed, 0.5, torque, voltage)
