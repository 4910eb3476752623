"""The best operation of a PM AC drive, whoever controls it: efficiency over speed and torque, and d-q currents."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, pi
from typing import Any, Final

import numpy as np

from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.fundamental import SteadyState, base_speed, most_torque_per_ampere, steady_state
from drivegate_models.pm_ac.oracle import LOSS, Limits, greatest_torque, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

MAP_SPEEDS: Final = 18
"""Speeds of the map."""
MAP_TORQUES: Final = 14
"""Torques at each, up to the greatest there."""

Rows = list[list[float]]
"""A row for each speed."""
CURRENTS: Final = 24
"""Steps of current from none to the limit."""
SPEEDS: Final = 24
"""Steps of speed from where the voltage is used up to overspeed."""
ANGLES: Final = 72
"""Directions of the voltage along its limit."""


def efficiency_map(drive: PmAcDocument) -> dict[str, Any]:
    """Compute the efficiency at least loss, of copper and core alone, at shares of the greatest torque over speed."""
    plant, rating = drive.plant(), drive.rating
    limits = undistorted_limits(plant)
    speeds = [rating.overspeed_rpm * (k + 1) / MAP_SPEEDS for k in range(MAP_SPEEDS)]
    shares = [(k + 1) / MAP_TORQUES for k in range(MAP_TORQUES)]
    most = [greatest_torque(plant, limits, speed * RADIANS_PER_RPM).torque for speed in speeds]
    return {
        "speed_rpm": speeds,
        "torque_nm": [[known(share * greatest) for share in shares] for greatest in most],
        "efficiency_percent": [
            [_efficiency(plant, limits, speed * RADIANS_PER_RPM, share * greatest) for share in shares]
            for speed, greatest in zip(speeds, most, strict=True)
        ],
    }


def known(value: float) -> float | None:
    """Return a number of the oracle, or None for what is out of reach."""
    return value if isfinite(value) else None


def efficiency(state: SteadyState, speed: float) -> float | None:
    """Return the mechanical power over that and the losses (%); None where no power is given to the shaft."""
    power = state.torque * speed
    return 100.0 * power / (power + state.loss) if power > 0.0 else None


def _efficiency(plant: PmAcDrive, limits: Limits, speed: float, torque: float) -> float | None:
    if not (isfinite(torque) and torque > 0.0):
        return None
    return efficiency(least_at(plant, limits, speed, torque, LOSS), speed)


def known_map(charted: Mapping[str, Any]) -> tuple[Rows, Rows, Rows]:
    """Return speed, torque and efficiency of a map at the speeds that have any torque; empty for fewer than two."""
    rows = zip(charted["speed_rpm"], charted["torque_nm"], charted["efficiency_percent"], strict=True)
    known = [row for row in rows if None not in (*row[1], *row[2])]
    if len(known) < 2:
        return [], [], []
    speeds = [[speed] * len(torques) for speed, torques, _ in known]
    return speeds, [torques for _, torques, _ in known], [values for *_, values in known]


def trajectories(drive: PmAcDocument) -> dict[str, Any]:
    """Compute most torque per ampere, greatest torque over speed, and the limits of voltage at both ends of it."""
    plant, rating = drive.plant(), drive.rating
    limits = undistorted_limits(plant)
    speeds = dict.fromkeys((rating.base_speed_rpm, rating.highest_speed_rpm))
    return {
        "most_torque_per_ampere": [
            _least(plant, current) for current in np.linspace(0.0, limits.current, CURRENTS + 1).tolist()
        ],
        "greatest_torque": _greatest(plant, limits, rating.overspeed_rpm, weakens=drive.weakens),
        "voltage_limits": [_voltage_limit(plant, limits.voltage, speed) for speed in speeds],
    }


def _least(plant: PmAcDrive, current: float) -> dict[str, float]:
    direct, quadrature = most_torque_per_ampere(plant, current)
    torque = steady_state(plant, 0.0, direct, quadrature).torque
    return {"current_a": current, "direct_a": direct, "quadrature_a": quadrature, "torque_nm": torque}


def _greatest(
    plant: PmAcDrive, limits: Limits, overspeed_rpm: float, *, weakens: bool
) -> list[dict[str, float]]:
    begin = min(base_speed(plant, *limits) / RADIANS_PER_RPM, overspeed_rpm)
    found = []
    for speed in np.linspace(begin, overspeed_rpm, SPEEDS + 1).tolist():
        state = greatest_within(plant, limits, speed * RADIANS_PER_RPM, weakens=weakens)
        if isfinite(state.torque):
            found.append(
                {
                    "speed_rpm": speed,
                    "direct_a": state.direct,
                    "quadrature_a": state.quadrature,
                    "torque_nm": state.torque,
                }
            )
    return found


def _voltage_limit(plant: PmAcDrive, voltage: float, speed_rpm: float) -> dict[str, Any]:
    """Return the currents that take a voltage, direction by direction: an ellipse."""
    electrical = plant.pole_pairs * speed_rpm * RADIANS_PER_RPM
    along, across = electrical * plant.direct_inductance, electrical * plant.quadrature_inductance
    determinant = plant.resistance * plant.resistance + along * across
    direct, quadrature = [], []
    for k in range(ANGLES + 1):
        cosine, sine = cosine_sine(2.0 * pi * k / ANGLES)
        first, second = voltage * cosine, voltage * sine - electrical * plant.magnet_flux
        direct.append((plant.resistance * first + across * second) / determinant if determinant else inf)
        quadrature.append((plant.resistance * second - along * first) / determinant if determinant else inf)
    return {"speed_rpm": speed_rpm, "direct_a": direct, "quadrature_a": quadrature}
