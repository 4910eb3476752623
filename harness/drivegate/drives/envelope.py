"""What a drive can do over speed: torque at the current limit, and rated power at the least cost."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan
from typing import Final

import numpy as np

from drivegate.drives.constant_power import last_met
from drivegate.drives.rating import RatedDrive, Rating
from drivegate.drives.required_ripple import ideal_ripple
from drivegate_models.steady import oracle
from drivegate_models.steady.oracle import AdvanceLine

BELOW_BASE: Final = 5
"""Speeds up to base speed, evenly spaced; at standstill itself there is no steady state."""
CONSTANT_POWER: Final = 20
"""Speeds from there to the highest."""
BEYOND: Final = 10
"""Speeds from there to overspeed."""
_FEW: Final = (2, 4, *range(6, 25, 2), 29, 34)
_HALVINGS: Final = 12


@dataclass(frozen=True)
class SpeedPoint:
    """What a drive can do at one speed; NaN where rated power is out of reach."""

    speed: float
    """Speed (rad/s)."""
    rated_torque: float
    """Torque of rated power, constant below base speed (N·m)."""
    greatest_torque: float
    greatest_torque_advance: float
    """Greatest torque at the current limit (N·m), and the advance angle that gives it (rad)."""
    torque_without_advance: float
    """Torque at the current limit and an angle of zero (N·m)."""
    edge: float
    """Smallest angle that gives rated torque (rad)."""
    advance: float
    """Angle that gives it with the least Σ|i| (rad)."""
    current_sum: float
    """Σ|i| there (A)."""
    input_power: float
    """Net input power there (W)."""
    ripple: float
    """Torque ripple there, peak to peak over mean, of the ideal regulator (1)."""
    line_advance: float
    """Angle of the recommended line (rad)."""
    line_torque: float
    """Torque at the current limit along it (N·m)."""


def speeds_of(rating: Rating) -> tuple[float, ...]:
    """Return the speeds at which a drive is looked at (rad/s)."""
    parts = (
        np.linspace(0.0, rating.base_speed, BELOW_BASE + 1)[1:],
        np.linspace(rating.base_speed, rating.highest_speed, CONSTANT_POWER + 1)[1:],
        np.linspace(rating.highest_speed, rating.overspeed, BEYOND + 1)[1:],
    )
    return tuple(float(speed) for part in parts for speed in part)


def few_speeds_of(rating: Rating) -> tuple[float, ...]:
    """Return those of them that a result has, since the least Σ|i| takes a twentieth of a second for each (rad/s)."""
    speeds = speeds_of(rating)
    return tuple(speeds[place] for place in _FEW)


def recommended_line(drive: RatedDrive) -> AdvanceLine:
    """Find the line of initial angles over the range of constant power."""
    rating = drive.rating
    return oracle.recommended_line(drive.constants, rating.base_speed, rating.highest_speed, rating.power)


def speed_without_advance(drive: RatedDrive) -> float | None:
    """Find the speed up to base speed to which rated torque takes no advance (rad/s); none where it always does."""
    low: float | None = None
    for speed in speeds_of(drive.rating)[:BELOW_BASE]:
        if not _needs_no_advance(drive, speed):
            if low is None:
                return None
            return last_met(lambda tried: _needs_no_advance(drive, tried), low, speed, _HALVINGS)
        low = speed
    return low


def _needs_no_advance(drive: RatedDrive, speed: float) -> bool:
    (torque,) = oracle.torques_at_limit(drive.constants, speed, [0.0])
    return bool(torque >= drive.demanded_torque(speed))


def least_in_hand(drive: RatedDrive, line: AdvanceLine) -> tuple[float, float] | None:
    """Find where the line leaves the least torque in hand (rad/s), and how much over rated torque (1)."""
    found: list[tuple[float, float]] = []
    rounding = 1e-9 * drive.rating.highest_speed
    for speed in speeds_of(drive.rating)[BELOW_BASE : BELOW_BASE + CONSTANT_POWER]:
        advance = line.angle(speed)
        if speed < drive.rating.lowest_speed - rounding or not isfinite(advance):
            continue
        (torque,) = oracle.torques_at_limit(drive.constants, speed, [advance])
        found.append((float(torque) / drive.demanded_torque(speed) - 1.0, speed))
    if not found:
        return None
    in_hand, speed = min(found)
    return speed, in_hand


def speed_point(drive: RatedDrive, line: AdvanceLine, speed: float) -> SpeedPoint:
    """Compute what a drive can do at a speed (rad/s)."""
    constants = drive.constants
    torque = drive.demanded_torque(speed)
    greatest = oracle.greatest_torque_at_limit(constants, speed)
    advance = line.angle(speed)
    at_zero, at_line = oracle.torques_at_limit(constants, speed, [0.0, advance if isfinite(advance) else 0.0])
    edge = oracle.feasible_edge(constants, speed, torque)
    best = oracle.least_current_sum(constants, speed, torque)
    return SpeedPoint(
        speed=speed,
        rated_torque=torque,
        greatest_torque=greatest.torque,
        greatest_torque_advance=greatest.advance,
        torque_without_advance=float(at_zero),
        edge=edge,
        advance=best.advance,
        current_sum=best.current_sum,
        input_power=best.input_power,
        ripple=ideal_ripple(drive, speed, torque, best.advance),
        line_advance=advance,
        line_torque=float(at_line) if isfinite(advance) else nan,
    )
