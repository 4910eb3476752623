"""When something fails so that a controller can be expected to notice it, and it is clear what is safe then."""

from __future__ import annotations

from typing import Final

from drivegate.scenarios.drive_scale import rated_torque_at
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario

FAILURE_TORQUE_SHARE: Final = 0.3
"""Least torque under which something fails, over rated torque: without a current no phase or sensor is missed (1)."""
_ROUNDING: Final = 0.01
"""What speeds and torques that people can read are rounded by, over base speed and rated torque (1)."""


def unnoticed_because(scenario: Scenario) -> str | None:
    """Return why nobody is judged on what a controller does after the failure in a scenario, if there is one."""
    failure, drive = scenario.failure, scenario.drive
    if failure is None or not isinstance(drive, PmAcDocument):
        return None
    base = drive.rating.base_speed_rpm
    # On a change of the reference the shaft is still at the speed before it.
    reference = abs(value_from(scenario.speed_rpm, failure.time_s))
    turning = reference if failure.time_s > 0.0 else abs(scenario.initial_speed_rpm)
    locks = failure.kind == "locked-rotor"
    # A shaft that locks shows it by its sudden stop, or by not starting.
    speed = max(turning, reference) if locks else min(turning, reference)
    if speed < (FAILURE_SPEED_SHARE - _ROUNDING) * base:
        return f"something fails below {100.0 * FAILURE_SPEED_SHARE:g} % of base speed, where it takes too long to show"
    if max(turning, *(abs(speed) for _, speed in scenario.speed_rpm)) > (1.0 + _ROUNDING) * base:
        return (
            "something fails above base speed, where legs that are off rectify and may not be the safe state"
        )
    least = (FAILURE_TORQUE_SHARE - _ROUNDING) * rated_torque_at(drive, speed)
    if not locks and abs(_torque(scenario)) < least:
        return (
            f"something fails below {100.0 * FAILURE_TORQUE_SHARE:g} % of rated torque, where it may not show"
        )
    return None


def _torque(scenario: Scenario) -> float:
    """Return the torque that is asked for, or that the load demands, as something fails (N·m)."""
    load, failure = scenario.load, scenario.failure
    assert failure is not None, "something fails in such a scenario"
    if isinstance(load, DynamometerLoad):
        return value_from(load.torque_reference_nm, failure.time_s)
    if isinstance(load, LockedLoad):
        return 0.0
    share = value_from(scenario.load_profile, failure.time_s)
    return load.torque_at(value_from(scenario.speed_rpm, failure.time_s), share)
