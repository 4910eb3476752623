"""The range that scenarios of a PM AC drive are drawn from."""

from __future__ import annotations

from typing import Final

from drivegate.contracts.duty.scenarios.failures import FAILURE_TORQUE_SHARE
from drivegate.contracts.duty.scenarios.position_errors import greatest_angle_error
from drivegate.scenarios.drawn_range import NONE, DrawnRange, Interval
from drivegate.scenarios.drive_scale import rated_torque_at
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.scenario.load import DynamometerLoad, HoistLoad, LockedLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import ShuntSensors

SHARE_STEP: Final = 0.05
"""Step of drawn torques and loads over rated torque, and the least of them (1)."""
TURNING_SHARE: Final = 0.1
"""Least speed reference over base speed (1)."""
HEAVIEST_SHARE: Final = 0.85
"""Heaviest load of a speed reference over rated torque (1)."""
HEAVIEST_FAILURE_SHARE: Final = 0.6
"""Greatest torque under which something fails, over rated torque (1)."""
BRAKING_SHARE: Final = 1.0
"""Greatest torque reference against the rotation, over rated torque (1)."""
SLOW_SHARE: Final = 0.01
"""Least speed reference of a run at low speed over base speed (1); it ends at `TURNING_SHARE`."""
SLOW_LOAD_SHARE: Final = 0.2
"""Heaviest load at the end of low speeds over rated torque, and less in proportion to the speed below it (1): more
stops the shaft before a regulator of its speed can act."""
BEYOND_SHARE: Final = 3.0
"""Torque reference that no drive of this kind can follow in weakening, over the one of rated power there (1)."""


def drawn_range(scenario: Scenario) -> DrawnRange:
    """Return the range of the family that a scenario belongs to: of a failure, a disturbance, a torque, or a speed."""
    rating, sensors = scenario.drive.rating, scenario.sensors
    base, highest = rating.base_speed_rpm, rating.highest_speed_rpm
    if isinstance(sensors, ShuntSensors) and sensors.shunts == "low-side":
        # At full voltage such shunts see no two phases.
        highest = base
    if scenario.failure is not None:
        speeds = Interval(FAILURE_SPEED_SHARE * base, base)
        return DrawnRange(speeds, speeds, Interval(FAILURE_TORQUE_SHARE, HEAVIEST_FAILURE_SHARE), NONE)
    is_disturbed = scenario.restarts_s or scenario.dropouts or scenario.glitches or scenario.clock_start_s
    if is_disturbed or greatest_angle_error(scenario) > 0.0:
        speeds = Interval(TURNING_SHARE * base, base)
        return DrawnRange(speeds, speeds, Interval(SHARE_STEP, HEAVIEST_SHARE), NONE)
    if isinstance(scenario.load, DynamometerLoad):
        beyond = _is_beyond(scenario)
        speeds = Interval(base if beyond else 0.0, highest)
        driving = Interval(SHARE_STEP, BEYOND_SHARE if beyond else 1.0)
        return DrawnRange(speeds, speeds, driving, Interval(0.0, BRAKING_SHARE))
    starts = scenario.initial_speed_rpm == 0.0
    if is_slow(scenario):
        speeds = Interval(SLOW_SHARE * base, TURNING_SHARE * base)
        return DrawnRange(speeds, Interval(0.0, highest), Interval(0.0, SLOW_LOAD_SHARE), NONE)
    bounded = starts or isinstance(scenario.load, HoistLoad)
    speeds = Interval(TURNING_SHARE * base, base if bounded else highest)
    return DrawnRange(speeds, speeds, Interval(SHARE_STEP, HEAVIEST_SHARE), NONE)


def slow_load_share(speed_rpm: float, drive: DriveDocument) -> float:
    """Return the heaviest load at a low speed of either sign over rated torque (1)."""
    return SLOW_LOAD_SHARE * abs(speed_rpm) / (TURNING_SHARE * drive.rating.base_speed_rpm)


def is_slow(scenario: Scenario) -> bool:
    """Return True if a run of a speed reference ends below the least speed of the other families."""
    is_held = isinstance(scenario.load, (DynamometerLoad, LockedLoad))
    return (
        not is_held and abs(scenario.speed_rpm[-1][1]) < TURNING_SHARE * scenario.drive.rating.base_speed_rpm
    )


def _is_beyond(scenario: Scenario) -> bool:
    """Return True if a torque reference asks for more than rated power above base speed."""
    reference = scenario.speed_rpm[0][1]
    speed, sense = abs(reference), sense_of(reference)
    most = max(sense * torque for _, torque in scenario.torque_reference_profile)
    above = speed > scenario.drive.rating.base_speed_rpm
    return above and most > (1.0 + SHARE_STEP) * rated_torque_at(scenario.drive, speed)
