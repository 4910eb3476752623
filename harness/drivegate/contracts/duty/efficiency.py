"""The efficiency of a PM AC drive over speed and torque, whoever controls it."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any, Final

from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.fundamental import SteadyState
from drivegate_models.pm_ac.oracle import LOSS, Limits, greatest_torque, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

MAP_SPEEDS: Final = 18
"""Speeds of the map."""
MAP_TORQUES: Final = 14
"""Torques at each, up to the greatest there."""

Rows = list[list[float]]
"""A row for each speed."""


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
