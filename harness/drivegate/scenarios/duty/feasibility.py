"""What no controller of duty ratios could do: the rules for scenarios that a candidate may fairly be judged on."""

from __future__ import annotations

from functools import lru_cache
from math import isfinite
from typing import Final

from drivegate.scenarios.duty.failures import unnoticed_because
from drivegate.scenarios.duty.windows import DutyDwell, duty_dwells
from drivegate_cases.drive.data_sheet import USABLE_SHARE
from drivegate_cases.drive.scales import NOMINAL, Scales
from drivegate_cases.scenario.load import LockedLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.oracle import greatest_torque, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

IN_HAND: Final = USABLE_SHARE
"""Share of the greatest torque that a speed's load may take; the rest is for regulation (1)."""
_KEPT: Final = 20_000


def unfair_because(scenario: Scenario) -> str | None:
    """Tell why a candidate may not be judged on a scenario; a torque reference out of reach is judged as such."""
    differs = scenario.scales != NOMINAL
    if differs and scenario.initial_speed_rpm > scenario.drive.rating.base_speed_rpm:
        return "it begins above base speed without any current, on a plant that the controller does not know"
    if (unnoticed := unnoticed_because(scenario)) is not None:
        return unnoticed
    if isinstance(scenario.load, LockedLoad):
        return None
    if not all(_is_driven(scenario, dwell) for dwell in duty_dwells(scenario)):
        return "at one of its operating points no currents within the limits give the torque"
    return None


def _is_driven(scenario: Scenario, dwell: DutyDwell) -> bool:
    load = scenario.load
    assert not isinstance(load, LockedLoad), "a held shaft has no load"
    speed = dwell.speed_rpm * RADIANS_PER_RPM
    idle = dwell.load_factor == 0.0 == dwell.speed_rpm
    demanded = 0.0 if idle else load.torque_at(dwell.speed_rpm, dwell.load_factor)
    scales = scenario.scales
    changed = scales.model_copy(
        update={
            "resistance": scales.resistance * dwell.resistance_factor,
            "emf_constant": scales.emf_constant * dwell.emf_factor,
        }
    )
    plant = _plant(scenario, changed)
    drag = plant.friction + plant.viscous_friction * speed
    return demanded + drag <= IN_HAND * _greatest(plant, speed, 2.0 * dwell.supply_v)


def _plant(scenario: Scenario, scales: Scales) -> PmAcDrive:
    # The drive of a scenario may be of any kind; these scenarios are drawn for this one alone.
    plant: PmAcDrive = scenario.drive.plant(scales)  # type: ignore[assignment]
    return plant


@lru_cache(maxsize=_KEPT)
def _greatest(plant: PmAcDrive, speed: float, link: float) -> float:
    """Find the greatest torque (N·m); below every load where the limits leave none."""
    torque = greatest_torque(plant, undistorted_limits(plant, link), speed).torque
    return torque if isfinite(torque) else -1.0
