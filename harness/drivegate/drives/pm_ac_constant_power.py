"""How far a PM AC drive keeps its rated power: the greatest power over speed within its limits."""

from __future__ import annotations

import numpy as np

from drivegate.drives.constant_power import SPEEDS, ConstantPower
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.oracle import constant_power_end, greatest_torque, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM


def pm_ac_constant_power(drive: PmAcDocument) -> ConstantPower:
    """Find the range of constant power of a PM AC drive, overspeed at most, from base speed on."""
    rating, plant = drive.rating, drive.plant()
    limits = undistorted_limits(plant)
    first, last = (speed * RADIANS_PER_RPM for speed in (rating.base_speed_rpm, rating.overspeed_rpm))
    speeds = [float(speed) for speed in np.linspace(first, last, SPEEDS)]
    powers = [float(greatest_torque(plant, limits, speed).torque * speed) for speed in speeds]
    end = constant_power_end(plant, limits, rating.rated_power_w)
    return ConstantPower(
        tuple(speeds), tuple(powers), min(end, last) if powers[0] >= rating.rated_power_w else None
    )
