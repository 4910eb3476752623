"""What a PM AC drive can do over speed, whoever controls it: greatest torque, least current and least loss."""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

import numpy as np

from drivegate.contracts.duty.efficiency import efficiency_map, known
from drivegate.contracts.duty.trajectories import trajectories
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import duty_limits_of
from drivegate_models.pm_ac.fundamental import SIX_STEPS, base_speed
from drivegate_models.pm_ac.oracle import (
    CURRENT,
    LOSS,
    Limits,
    constant_power_end,
    greatest_torque,
    least_at,
    undistorted_limits,
)
from drivegate_models.units import RADIANS_PER_RPM

BELOW_BASE: Final = 4
"""Steps of speed from standstill to base speed."""
CONSTANT_POWER: Final = 8
"""Steps from there to the highest."""


def pm_ac_envelope(drive: PmAcDocument) -> dict[str, Any]:
    """Compute what a drive can do, as plain data in people's units; None where something is out of reach."""
    rating, plant = drive.rating, drive.plant()
    limits = undistorted_limits(plant)
    begin = base_speed(plant, *limits)
    end = constant_power_end(plant, limits, rating.rated_power_w)
    return {
        "rating": {
            "base_speed_rpm": rating.base_speed_rpm,
            "highest_speed_rpm": rating.highest_speed_rpm,
            "overspeed_rpm": rating.overspeed_rpm,
            "rated_power_w": rating.rated_power_w,
            "current_limit_a": rating.current_limit_a,
        },
        "control_period_s": drive.inverter.control_period_s,
        "settling_s": duty_limits_of(drive).settling_s,
        "undistorted_voltage_v": limits.voltage,
        "six_step_voltage_v": SIX_STEPS * plant.link_voltage,
        "magnet_current_a": plant.magnet_flux / plant.direct_inductance,
        "voltage_used_up_at_rpm": begin / RADIANS_PER_RPM,
        "rated_power_up_to_rpm": end / RADIANS_PER_RPM if isfinite(end) else None,
        "points": [_point(drive, limits, speed) for speed in _speeds(drive)],
        "trajectories": trajectories(drive),
        "efficiency_map": efficiency_map(drive),
    }


def _speeds(drive: PmAcDocument) -> list[float]:
    rating = drive.rating
    parts = (
        np.linspace(0.0, rating.base_speed_rpm, BELOW_BASE + 1),
        np.linspace(rating.base_speed_rpm, rating.highest_speed_rpm, CONSTANT_POWER + 1)[1:],
        [rating.overspeed_rpm],
    )
    return list(dict.fromkeys(float(speed) for part in parts for speed in part))


def _point(drive: PmAcDocument, limits: Limits, speed_rpm: float) -> dict[str, float | None]:
    plant, rating = drive.plant(), drive.rating
    speed = speed_rpm * RADIANS_PER_RPM
    rated = rating.rated_power_w / (max(speed_rpm, rating.base_speed_rpm) * RADIANS_PER_RPM)
    most = greatest_torque(plant, limits, speed)
    least, cool = (least_at(plant, limits, speed, rated, purpose) for purpose in (CURRENT, LOSS))
    return {
        "speed_rpm": speed_rpm,
        "rated_torque_nm": rated,
        "greatest_torque_nm": known(most.torque),
        "greatest_power_w": known(most.torque * speed),
        "greatest_direct_a": known(most.direct),
        "greatest_quadrature_a": known(most.quadrature),
        "least_current_a": known(least.current),
        "direct_a": known(least.direct),
        "quadrature_a": known(least.quadrature),
        "voltage_v": known(least.voltage),
        "loss_w": known(least.loss),
        "least_loss_w": known(cool.loss),
        "least_loss_direct_a": known(cool.direct),
    }
