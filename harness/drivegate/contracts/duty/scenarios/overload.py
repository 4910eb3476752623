"""A load that stops a shaft without a position sensor, which no torque within the limits bears."""

from __future__ import annotations

from functools import lru_cache
from math import inf, isfinite
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.oracle import undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive

OVERLOAD: Final = 1.5
"""Load of an overload over the greatest torque of a shaft at rest (1)."""
_ROUNDING: Final = 0.01


@lru_cache(maxsize=256)
def greatest_at_rest(plant: PmAcDrive, link: float) -> float:
    """Return the greatest torque of a shaft at rest within the limits, at a link voltage (V), in N·m."""
    torque = greatest_within(plant, undistorted_limits(plant, link), 0.0, weakens=True).torque
    return float(torque) if isfinite(torque) else inf


def overloaded_s(scenario: Scenario) -> tuple[float, float]:
    """Return the times at which an overload begins to rise, and at which it is whole (s); infinite without any.

    It is the last change of the load of a drive without a position sensor.
    """
    load, drive, profile = scenario.load, scenario.drive, scenario.load_profile
    rises = len(profile) > 1 and profile[-2][1] < profile[-1][1]
    if drive.position != "none" or not isinstance(load, ConstantTorqueLoad) or not rises:
        return inf, inf
    torque = load.torque_at(0.0, profile[-1][1])
    if torque <= drive.rating.rated_torque_nm:
        return inf, inf
    (begin, _), (end, _) = profile[-2:]
    plant, supply = duty_document(drive).plant(scenario.scales), value_from(scenario.supply_profile, end)
    is_overload = torque >= (1.0 - _ROUNDING) * OVERLOAD * greatest_at_rest(plant, 2.0 * supply)
    return (begin, end) if is_overload else (inf, inf)
