"""The torque at the current limit, and the line of initial angles that follows from it."""

from __future__ import annotations

from math import degrees, isnan, nan, pi, radians

import numpy as np
import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.steady.advance_line import RESERVE, SPEEDS, demanded_torque
from drivegate_models.steady.oracle import (
    AdvanceLine,
    feasible_edge,
    greatest_torque_at_limit,
    recommended_line,
    torques_at_limit,
)
from drivegate_models.steady.steady_state import steady_state

RPM = pi / 30.0
BASE, HIGHEST = 500.0 * RPM, 1500.0 * RPM


@pytest.fixture(scope="module")
def drive() -> Drive:
    return load_drive("paper-5-phase").plant()


def line_of(drive: Drive, highest: float = HIGHEST) -> AdvanceLine:
    return recommended_line(drive, BASE, highest, 1500.0)


def in_hand(drive: Drive, line: AdvanceLine, speed: float) -> float:
    """Return the torque along a line over rated torque, less 1."""
    (given,) = torques_at_limit(drive, speed, [line.angle(speed)])
    return float(given) / demanded_torque(drive, speed, BASE, 1500.0) - 1.0


def test_the_torque_at_the_limit_is_that_of_the_steady_state(drive: Drive) -> None:
    torques = torques_at_limit(drive, HIGHEST, [0.0, radians(52.5)])
    assert torques[0] == steady_state(drive, HIGHEST, 26.0, 0.0).torque
    assert torques[1] == steady_state(drive, HIGHEST, 26.0, radians(52.5)).torque


@pytest.mark.parametrize("rpm", [100.0, 500.0, 900.0, 2000.0])
def test_no_angle_gives_more_than_the_greatest_torque(drive: Drive, rpm: float) -> None:
    most = greatest_torque_at_limit(drive, rpm * RPM)
    fine = torques_at_limit(drive, rpm * RPM, np.radians(np.arange(0.0, 90.0, 0.25)))
    assert fine.max() <= most.torque * 1.0001, "an angle between the grid's gives noticeably more"
    assert torques_at_limit(drive, rpm * RPM, [most.advance])[0] == most.torque
    just_below, just_above = 0.998 * most.torque, 1.001 * most.torque
    assert not isnan(feasible_edge(drive, rpm * RPM, just_below))
    assert isnan(feasible_edge(drive, rpm * RPM, just_above))


def test_rated_power_at_base_speed_is_the_calibrated_fact(drive: Drive) -> None:
    most = greatest_torque_at_limit(drive, BASE)
    assert most.torque * BASE == pytest.approx(1504.0, abs=1.0)
    assert degrees(most.advance) == pytest.approx(33.0, abs=0.5)


def test_the_line_keeps_rated_power_with_torque_in_hand(drive: Drive) -> None:
    line = line_of(drive)
    reserves = {rpm: in_hand(drive, line, rpm * RPM) for rpm in range(500, 1501, 25)}
    assert min(reserves.values()) > 0.0, f"rated power is lost along the line: {reserves}"
    well = [reserves[rpm] for rpm in range(575, 1501, 25)]
    # Held at `SPEEDS` speeds, and rounded to 0.1 degree.
    assert min(well) > RESERVE - 0.004, f"the reserve is not held: {reserves}"
    assert min(well) < RESERVE + 0.01, "a line of least advance has no more in hand than it must"


def test_no_line_of_less_advance_holds_the_reserve(drive: Drive) -> None:
    line = line_of(drive)
    speeds = np.linspace(BASE, HIGHEST, SPEEDS)[2:]
    for start, end in ((-1.0, 0.0), (0.0, -1.0), (0.5, -1.0), (-1.5, 0.5)):
        slope = line.slope + radians(end - start) / (HIGHEST - BASE)
        lower = line._replace(start=line.start + radians(start), slope=slope)
        least = min(in_hand(drive, lower, float(speed)) for speed in speeds)
        assert least < RESERVE - 0.004, f"{start}° at base and {end}° at highest speed would do, too"


def test_on_the_papers_drive_it_is_near_the_line_that_was_found_by_hand(drive: Drive) -> None:
    line = line_of(drive)
    assert degrees(line.start) == pytest.approx(33.0, abs=0.5)
    assert degrees(line.slope) * RPM == pytest.approx(0.02, abs=0.001)
    assert line.angle(0.999 * BASE) == 0.0
    assert line.angle(1e9) == pytest.approx(pi / 2.0)


def test_a_drive_that_needs_no_advance_gets_none() -> None:
    strong = load_drive("paper-5-phase").replaced(supply_voltage_v=400.0).plant()
    line = line_of(strong)
    assert (line.start, line.slope) == (0.0, 0.0)


def test_speeds_out_of_reach_do_not_count_and_without_any_there_is_no_line() -> None:
    motor = load_drive("paper-5-phase")
    partly = motor.replaced(current_limit_a=20.0).plant()
    assert isnan(feasible_edge(partly, BASE, 1500.0 / BASE)), "at base speed 20 A must be too little"
    line = line_of(partly)
    assert in_hand(partly, line, HIGHEST) > 0.0
    nowhere = line_of(motor.replaced(current_limit_a=2.0).plant())
    assert isnan(nowhere.start)
    assert isnan(nowhere.slope)


def test_friction_is_part_of_what_rated_power_takes(drive: Drive) -> None:
    rubbing = drive._replace(friction=0.5, viscous_friction=0.01)
    more = demanded_torque(rubbing, HIGHEST, BASE, 1500.0) - demanded_torque(drive, HIGHEST, BASE, 1500.0)
    assert more == pytest.approx(0.5 + 0.01 * HIGHEST)
    assert demanded_torque(drive, 0.1 * BASE, BASE, 1500.0) == 1500.0 / BASE, "constant below base speed"


@pytest.mark.parametrize("speed", [0.0, -1.0, nan])
def test_a_speed_that_has_no_steady_state_is_refused(drive: Drive, speed: float) -> None:
    with pytest.raises(InputError, match="needs a finite speed above 0"):
        greatest_torque_at_limit(drive, speed)
