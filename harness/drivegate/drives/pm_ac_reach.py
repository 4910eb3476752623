"""What a PM AC drive can deliver of its rated power, and how long it takes to its highest speed."""

from __future__ import annotations

from math import isfinite
from typing import Final

import numpy as np

from drivegate.contracts.duty.scenarios.feasibility import IN_HAND
from drivegate.drives.power_reach import PowerReach, UnreachableRating, unreachable_power
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.oracle import greatest_torque, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

SPEEDS: Final = 13
"""Speeds from base speed to the highest at which rated power is looked for."""


def unreachable_duty(drive: PmAcDocument) -> UnreachableRating | None:
    """Find where rated power is out of reach, and the nearest ratings that are not."""
    return unreachable_power(drive, _reach, lambda changed: _reach(changed).is_met)


def _reach(drive: DriveDocument) -> PowerReach:
    assert isinstance(drive, PmAcDocument), "a changed drive is of the same kind"
    plant, rating = drive.plant(), drive.rating
    limits = undistorted_limits(plant)
    rpm = np.linspace(rating.base_speed_rpm, rating.highest_speed_rpm, SPEEDS)
    speeds = rpm * RADIANS_PER_RPM
    torques = [greatest_torque(plant, limits, float(speed)).torque for speed in speeds]
    return PowerReach(
        speeds=speeds,
        needed=rating.rated_power_w / speeds + plant.friction + plant.viscous_friction * speeds,
        greatest=np.array([IN_HAND * torque if isfinite(torque) else 0.0 for torque in torques]),
        reserve=1.0 - IN_HAND,
    )
