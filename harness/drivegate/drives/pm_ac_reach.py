"""Ratings of a PM AC drive that no controller can meet, with the nearest that can be met."""

from __future__ import annotations

from math import isfinite
from typing import Final

import numpy as np

from drivegate.contracts.duty.scenarios.feasibility import IN_HAND
from drivegate.contracts.duty.scenarios.windows import run_up_s
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.oracle import greatest_torque, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

SPEEDS: Final = 13
"""Speeds from base speed to the highest at which rated power is looked for."""
LONGEST_RUN_UP_S: Final = 60.0
"""Longest time of a free shaft to its highest speed (s): runs are longer than that several times."""


def refuse_unreachable_duty(drive: PmAcDocument) -> None:
    """Refuse a drive whose rating no controller can meet: no candidate is to be failed for it."""
    rating = drive.rating
    if (time := run_up_s(drive, rating.highest_speed_rpm)) > LONGEST_RUN_UP_S:
        raise InputError(
            f"the drive '{drive.name}' is too slow to be checked: it takes {time:.3g} s to its highest speed, and at "
            f"most {LONGEST_RUN_UP_S:g} s are taken; its inertia_kg_m2 is {drive.machine.inertia_kg_m2:g}, its rated "
            f"power {rating.rated_power_w:g} W"
        )
    if (sentence := unreachable_duty(drive)) is not None:
        raise InputError(f"no controller can meet what the drive '{drive.name}' requires: {sentence}")


def unreachable_duty(drive: PmAcDocument) -> str | None:
    """Tell where rated power is out of reach, and what is left there; None where it is in reach everywhere."""
    rating = drive.rating
    speeds = np.linspace(rating.base_speed_rpm, rating.highest_speed_rpm, SPEEDS)
    powers = {float(speed): _greatest_power(drive, float(speed)) for speed in speeds}
    speed = min(powers, key=lambda rpm: powers[rpm])
    if powers[speed] >= rating.rated_power_w:
        return None
    return (
        f"{rating.rated_power_w:g} W at {speed:.5g} rpm; {rating.current_limit_a:g} A and a link of "
        f"{drive.inverter.link_voltage_v:g} V leave {powers[speed]:.4g} W there, {100.0 * (1.0 - IN_HAND):.2g} % kept "
        "in hand for regulation"
    )


def _greatest_power(drive: PmAcDocument, speed_rpm: float) -> float:
    """Give the power that the limits leave for a load (W)."""
    plant, speed = drive.plant(), speed_rpm * RADIANS_PER_RPM
    torque = greatest_torque(plant, undistorted_limits(plant), speed).torque
    drag = plant.friction + plant.viscous_friction * speed
    return (IN_HAND * torque - drag) * speed if isfinite(torque) else 0.0
