"""Which runs are made a second time to be compared: with another dead time, or as their mirror image."""

from __future__ import annotations

from typing import Final

from drivegate.scenarios.rotation import mirrored
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import IDEAL

LOW_SPEED_SHARE: Final = 0.1
"""Speed over base speed up to which dead time is looked at (1)."""
DEAD_SHARE: Final = 0.02
"""Dead time over the control period that a drive without any is compared with (1)."""


def with_other_dead_time(scenario: Scenario) -> Scenario | None:
    """Make the run of another dead time that one is compared with; None where it is with none."""
    drive = scenario.drive
    speeds = {speed for _, speed in scenario.speed_rpm}
    if not (
        isinstance(drive, PmAcDocument)
        and _is_nominal(scenario)
        and isinstance(scenario.load, DynamometerLoad)
        and len(speeds) == 1
        and 0.0 < abs(scenario.speed_rpm[0][1]) <= LOW_SPEED_SHARE * drive.rating.base_speed_rpm
    ):
        return None
    own = drive.inverter.dead_time_s
    other = drive.replaced(dead_time_s=0.0 if own > 0.0 else DEAD_SHARE * drive.inverter.update_period_s)
    return scenario.replaced(drive=other)


def mirror_image(scenario: Scenario) -> Scenario | None:
    """Make the run forward that one backward is compared with; None where it is with none.

    What a speed regulator asks for depends on how it got there, so that only torque references are compared.
    """
    is_held = isinstance(scenario.load, DynamometerLoad)
    backward = is_held and all(speed < 0.0 for _, speed in scenario.speed_rpm)
    return mirrored(scenario) if backward and _is_nominal(scenario) else None


def _is_nominal(scenario: Scenario) -> bool:
    is_plain = scenario.scales == NOMINAL and scenario.drift is None and scenario.failure is None
    is_plain = is_plain and scenario.winding_temperature_c is None
    return is_plain and scenario.supply_v is None and scenario.sensors.kind == IDEAL.kind
