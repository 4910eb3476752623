"""What a drive can do, held against the oracle, the plant and the published facts."""

from dataclasses import replace
from math import degrees, inf, isfinite, isnan, pi, radians
from typing import Any

import pytest

from drivegate.drives.envelope import (
    BELOW_BASE,
    BEYOND,
    CONSTANT_POWER,
    SpeedPoint,
    ideal_ripple,
    recommended_line,
    speed_point,
    speed_without_advance,
    speeds_of,
)
from drivegate.drives.envelope_document import time_scales
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.steady import oracle
from drivegate_models.steady.oracle import least_current_sum, point_at_torque
from drivegate_models.steady.steady_state import steady_state

RPM = pi / 30.0


def drive_with(**changes: Any) -> RatedDrive:
    return rated_drive(load_drive("paper-5-phase").replaced(**changes))


@pytest.fixture(scope="module")
def drive() -> RatedDrive:
    return drive_with()


@pytest.fixture(scope="module")
def at_1500(drive: RatedDrive) -> SpeedPoint:
    return speed_point(drive, recommended_line(drive), 1500.0 * RPM)


def test_speeds_reach_from_near_standstill_to_overspeed_through_base_and_highest(drive: RatedDrive) -> None:
    speeds = [round(speed / RPM, 6) for speed in speeds_of(drive.rating)]
    assert len(speeds) == BELOW_BASE + CONSTANT_POWER + BEYOND
    assert speeds == sorted(set(speeds))
    assert (speeds[0], speeds[BELOW_BASE - 1], speeds[-1]) == (100.0, 500.0, 2000.0)
    assert speeds[BELOW_BASE + CONSTANT_POWER - 1] == 1500.0


def test_a_point_is_the_oracles_and_the_plants(drive: RatedDrive, at_1500: SpeedPoint) -> None:
    best = least_current_sum(drive.constants, 1500.0 * RPM, at_1500.rated_torque)
    assert at_1500.rated_torque == pytest.approx(9.549, abs=1e-3)
    assert (at_1500.advance, at_1500.current_sum) == (best.advance, best.current_sum)
    assert at_1500.torque_without_advance == steady_state(drive.constants, 1500.0 * RPM, 26.0, 0.0).torque
    along = steady_state(drive.constants, 1500.0 * RPM, 26.0, at_1500.line_advance).torque
    assert at_1500.line_torque == along
    assert at_1500.greatest_torque >= at_1500.line_torque > at_1500.rated_torque


def test_at_the_published_point_edge_and_ripple_are_the_published_ones(drive: RatedDrive) -> None:
    speed, torque = 1500.0 * RPM, 9.8
    edge = oracle.feasible_edge(drive.ideal, speed, torque)
    assert degrees(edge) == pytest.approx(52.0, abs=0.5), "Fig. 6 has 52° as necessary"
    assert ideal_ripple(drive, speed, torque, radians(52.5)) == pytest.approx(0.122, abs=1e-3)
    assert ideal_ripple(drive, speed, torque, 0.0) < 0.13, "below the edge it is the ripple at the edge"
    exact = point_at_torque(drive.ideal, speed, edge, torque)
    at_edge = (exact.torque_highest - exact.torque_lowest) / exact.torque
    assert ideal_ripple(drive, speed, torque, 0.0) == at_edge


def test_out_of_reach_there_are_no_values_but_the_torque_at_the_limit() -> None:
    weak = drive_with(current_limit_a=10.0)
    point = speed_point(weak, recommended_line(weak), 550.0 * RPM)
    assert 0.0 < point.greatest_torque < point.rated_torque
    lost = (point.edge, point.advance, point.current_sum, point.input_power, point.ripple)
    assert all(map(isnan, lost))


def test_where_rated_power_is_out_of_reach_throughout_there_is_no_line() -> None:
    hopeless = drive_with(current_limit_a=2.0)
    point = speed_point(hopeless, recommended_line(hopeless), 1000.0 * RPM)
    assert isnan(point.line_advance)
    assert isnan(point.line_torque)
    assert isfinite(point.greatest_torque)
    assert isnan(time_scales(hopeless, [point]).search)


def test_time_scales_follow_from_the_constants(drive: RatedDrive, at_1500: SpeedPoint) -> None:
    scales = time_scales(drive, [at_1500])
    assert scales.electrical == pytest.approx(2.88e-3 / 0.08)
    assert scales.current_rise == pytest.approx(2.88e-3 * 26.0 / 48.0)
    assert scales.mechanical_at_base == pytest.approx(0.05 * (500.0 * RPM) ** 2 / 1500.0)
    assert scales.mechanical_at_highest == pytest.approx(0.05 * (1500.0 * RPM) ** 2 / 1500.0)
    assert scales.electrical_frequency == pytest.approx(11.0 * 1500.0 / 60.0)
    assert scales.half_cycle == pytest.approx(0.5 / 275.0)
    assert scales.run_up == pytest.approx(0.05 * (1500.0**2 - 500.0**2) * RPM**2 / 3000.0)


def test_the_control_period_is_bound_by_what_is_shorter(drive: RatedDrive, at_1500: SpeedPoint) -> None:
    light = time_scales(drive, [at_1500])
    assert light.control_period == light.drift == pytest.approx(0.914e-3, rel=1e-3)
    heavy = time_scales(drive_with(inertia_kg_m2=0.5), [at_1500])
    assert heavy.control_period == heavy.half_cycle
    assert heavy.decision == heavy.mechanical_at_base
    tiny = time_scales(drive_with(inertia_kg_m2=1e-3), [at_1500])
    assert tiny.decision == pytest.approx(5.0 / (11.0 * 500.0 / 60.0))


def test_a_search_takes_a_decision_for_each_degree(drive: RatedDrive, at_1500: SpeedPoint) -> None:
    near = replace(at_1500, line_advance=at_1500.advance + radians(1.9))
    far = replace(at_1500, line_advance=at_1500.advance + radians(10.9))
    scales = time_scales(drive, [near, far])
    assert scales.search == pytest.approx((11 + 3) * scales.decision)
    beyond = replace(far, speed=2000.0 * RPM)
    assert time_scales(drive, [near, beyond]).search == pytest.approx((2 + 3) * scales.decision)


def test_without_resistance_a_winding_never_loses_its_current(at_1500: SpeedPoint) -> None:
    assert time_scales(drive_with(resistance_ohm=0.0), [at_1500]).electrical == inf


def test_up_to_some_speed_rated_torque_takes_no_advance(drive: RatedDrive) -> None:
    speed = speed_without_advance(drive)
    assert speed is not None
    needed = drive.demanded_torque(speed)
    assert steady_state(drive.constants, speed, 26.0, 0.0).torque >= needed
    assert steady_state(drive.constants, 1.01 * speed, 26.0, 0.0).torque < needed
    assert speed_without_advance(drive_with(current_limit_a=10.0)) is None
    strong = drive_with(supply_voltage_v=400.0)
    assert speed_without_advance(strong) == pytest.approx(strong.rating.base_speed)


def test_a_band_too_narrow_to_be_seen_is_taken_as_none(drive: RatedDrive, at_1500: SpeedPoint) -> None:
    assert drive.has_band
    assert drive.constants.hysteresis_band == 0.25
    narrow = drive_with(hysteresis_band_a=0.01)
    assert not narrow.has_band
    assert narrow.constants.hysteresis_band == 0.0
    assert drive_with(hysteresis_band_a=0.0).has_band, "a drive without a band is taken as it is"
    exact = load_drive("paper-5-phase").replaced(hysteresis_band_a=0.01).plant()
    at_limit = steady_state(exact, 1500.0 * RPM, 26.0, at_1500.line_advance).torque
    (taken,) = oracle.torques_at_limit(narrow.constants, 1500.0 * RPM, [at_1500.line_advance])
    assert taken == pytest.approx(at_limit, rel=1e-3)
