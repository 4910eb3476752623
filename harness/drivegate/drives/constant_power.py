"""How far a drive maintains its rated power: the greatest power over speed, and edges found by halving."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from drivegate.drives.rating import RatedDrive
from drivegate_models.steady import oracle

SPEEDS: Final = 41
"""Speeds from the lowest loaded to overspeed at which the greatest power is found."""
_HALVINGS: Final = 12


def last_met(is_met: Callable[[float], bool], met: float, missed: float, halvings: int) -> float:
    """Return the value nearest to where a condition ceases to be met that still meets it.

    `met` and `missed` are a value that meets it and one that does not, in either order.
    """
    for _ in range(halvings):
        middle = 0.5 * (met + missed)
        if is_met(middle):
            met = middle
        else:
            missed = middle
    return met


@dataclass(frozen=True)
class ConstantPower:
    speeds: tuple[float, ...]
    """Speeds from the lowest at which rated power is required to overspeed (rad/s)."""
    powers: tuple[float, ...]
    """Greatest power at the shaft that some angle gives there at the current limit (W)."""
    reached: float | None
    """Speed up to which that is rated power without a gap (rad/s), overspeed at most; None where it is not
    from the first speed on."""


def constant_power(drive: RatedDrive) -> ConstantPower:
    """Find the greatest power of a drive over speed, and how far constant power reaches."""
    rating = drive.rating
    speeds = [float(speed) for speed in np.linspace(rating.lowest_speed, rating.overspeed, SPEEDS)]
    powers = [greatest_shaft_power(drive, speed) for speed in speeds]
    missing = next((place for place, power in enumerate(powers) if not power >= rating.power), None)
    reached: float | None = None
    if missing is None:
        reached = rating.overspeed
    elif missing:
        met, missed = speeds[missing - 1], speeds[missing]
        reached = last_met(
            lambda speed: greatest_shaft_power(drive, speed) >= rating.power, met, missed, _HALVINGS
        )
    return ConstantPower(tuple(speeds), tuple(powers), reached)


def greatest_shaft_power(drive: RatedDrive, speed: float) -> float:
    """Find the greatest power at the shaft, after friction, at the current limit and a speed (W).

    The envelope's `greatest_power_w` is before friction: the electromagnetic torque times the speed. The core loss's
    drag is taken off neither.
    """
    greatest = oracle.greatest_torque_at_limit(drive.constants, speed).torque
    return float((greatest - drive.demanded_torque(speed)) * speed + drive.rating.power)
