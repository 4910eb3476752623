"""The q current that a candidate which follows a current gets in place of a torque reference."""

from __future__ import annotations

from functools import lru_cache
from math import copysign, isfinite
from typing import Final

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.reference import Reference
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.fundamental import most_torque_per_ampere, steady_state
from drivegate_models.pm_ac.oracle import CURRENT, least_at, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

STEPPED: Final[tuple[Reference, ...]] = ("torque",)
"""References of the scenarios of a candidate that follows a q current."""
_KEPT: Final = 20_000


@lru_cache(maxsize=_KEPT)
def quadrature_for(drive: PmAcDocument, torque: float) -> float:
    """Return the q current of least current (A) for a torque (N·m) by the nameplate, that of the limit at most."""
    plant = drive.plant()
    least = least_at(plant, undistorted_limits(plant), 0.0, torque, CURRENT)
    if isfinite(least.quadrature):
        return float(least.quadrature)
    return copysign(most_torque_per_ampere(plant, plant.current_limit)[1], torque)


def quadrature_profile(scenario: Scenario, torques: Profile) -> Profile:
    """Return the q current (A) over time for torques (N·m) of a scenario."""
    drive = duty_document(scenario.drive)
    return tuple((time, quadrature_for(drive, torque)) for time, torque in torques)


def is_current_in_reach(scenario: Scenario) -> bool:
    """Return True if every q current of a scenario needs no field weakening, with the d current of MTPA or without."""
    drive = duty_document(scenario.drive)
    plant, share = drive.plant(), limits_of(drive).weakening_voltage
    is_enough = all(
        voltage_along_none(drive, dwell.speed_rpm, dwell.torque_reference_nm or 0.0)
        <= undistorted_limits(plant, 2.0 * share * dwell.supply_v).voltage
        for dwell in duty_dwells(scenario)
    )
    return is_enough and unfair_because(scenario.replaced(drive=without_weakening(drive))) is None


def voltage_along_none(drive: PmAcDocument, speed_rpm: float, torque: float) -> float:
    """Return the peak voltage of a phase (V) for the q current of a torque (N·m) without a d current."""
    speed = speed_rpm * RADIANS_PER_RPM
    return float(steady_state(drive.plant(), speed, 0.0, quadrature_for(drive, torque)).voltage)


def without_weakening(drive: PmAcDocument) -> PmAcDocument:
    """Return a drive whose scenarios need no field weakening."""
    return duty_document(drive.replaced(highest_speed_rpm=drive.rating.base_speed_rpm))


def unless_current(declaration: Declaration, _drive: DriveDocument) -> str | None:
    """State why a check of the d current, or of the torque, does not apply to a candidate that follows a q current."""
    if not declaration.follows_current:
        return None
    return "the candidate follows a q current: the d current, and with it the torque, is its own choice"
