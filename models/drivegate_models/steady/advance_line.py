"""The line of initial advance angles (paper, Fig. 3), computed from a drive's feasible angles.

The paper chooses the slope "in such a way that constant power operation can be guaranteed over the desired high speed
range", from an angle of zero at base speed. This line need not exist, so here its initial angle is free, too. Of all
straight lines that maintain rated power with a torque reserve from base speed to the highest speed, it is the one with
minimum advance.
"""

from __future__ import annotations

from itertools import combinations
from math import nan, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.steady.torque_limit import HIGHEST_DEGREES, torques_at_limit

RESERVE: float = 0.05
"""Torque reserve of the line where the drive can produce it, relative to rated torque (1)."""
SPEEDS: int = 21
"""Number of speeds from base to highest at which the line is compared with the feasible angles."""

_FEWEST_SPEEDS = 2
_MAXIMUM_DEGREES = float(HIGHEST_DEGREES)
_SAME = 1e-9


class AdvanceLine(NamedTuple):
    """A straight line of advance angles above base speed; NaN if rated power is out of reach at all speeds."""

    base_speed: float
    """Speed at which the line begins (rad/s); there is no advance below."""
    start: float
    """Angle at base speed (rad electrical)."""
    slope: float
    """Slope over shaft speed (rad electrical per rad/s)."""

    def angle(self, speed: float) -> float:
        """Return the advance angle at a speed (rad/s), 0 to a quarter cycle (rad electrical)."""
        if speed < self.base_speed:
            return 0.0
        return min(max(self.start + self.slope * (speed - self.base_speed), 0.0), radians(HIGHEST_DEGREES))


class _Feasible(NamedTuple):
    """The feasible angles at a speed."""

    speed: float
    """Shaft speed (rad/s)."""
    lowest: float
    """Smallest feasible angle (deg)."""
    highest: float
    """Largest feasible angle (deg)."""


def demanded_torque(drive: AnyDrive, speed: float, base_speed: float, rated_power: float) -> float:
    """Return the electromagnetic torque of rated power: constant up to base speed, of constant power above.

    `speed`: shaft speed (rad/s), above 0. `base_speed`: base speed (rad/s). `rated_power`: rated power (W). Result:
    torque (N m). As everywhere in the oracle, it does not include the core loss's drag on the shaft.
    """
    return rated_power / max(speed, base_speed) + friction_torque(drive, speed)


def recommended_line(
    drive: AnyDrive, base_speed: float, highest_speed: float, rated_power: float
) -> AdvanceLine:
    """Return the line of minimum advance that maintains rated power from base speed to the highest speed.

    At each of `SPEEDS` speeds, an angle is feasible if it produces `RESERVE` more than rated torque at the current
    limit, or half of the drive's torque beyond rated torque if that is less. Feasible angles are a range around the
    angle of maximum torque, from a grid of 1 degree with linear interpolation. Speeds at which rated torque is out
    of reach are ignored. The best line always passes through two ends of these ranges, so all of these lines are
    compared: first by how far they leave the ranges (zero if a feasible line exists), then by their mean angle.

    `base_speed`, `highest_speed`: ends of the constant power range (rad/s), the first below the second. `rated_power`:
    rated power (W). Result: with both ends rounded to 0.1 degree.
    """
    found = (
        _feasible(drive, float(speed), demanded_torque(drive, float(speed), base_speed, rated_power))
        for speed in np.linspace(base_speed, highest_speed, SPEEDS)
    )
    ranges = [span for span in found if span is not None]
    if len(ranges) < _FEWEST_SPEEDS:
        return AdvanceLine(base_speed, nan, nan)
    start, end = _least_line(ranges, base_speed, highest_speed)
    start, end = round(max(start, 0.0), 1), round(max(end, 0.0), 1)
    return AdvanceLine(base_speed, radians(start), radians(end - start) / (highest_speed - base_speed))


def _feasible(drive: AnyDrive, speed: float, rated: float) -> _Feasible | None:
    """Return the feasible angles around the angle of maximum torque, None if there are none."""
    torques = torques_at_limit(drive, speed, np.radians(np.arange(HIGHEST_DEGREES + 1)))
    best = int(np.argmax(torques))
    most = float(torques[best])
    if most < rated:
        return None
    demanded = rated + min(RESERVE * rated, 0.5 * (most - rated))
    below = torques < demanded
    first = best - int(np.argmax(below[best::-1])) if below[: best + 1].any() else -1
    last = best + int(np.argmax(below[best:])) if below[best:].any() else HIGHEST_DEGREES + 1
    lowest = 0.0 if first < 0 else _crossing(torques, first, first + 1, demanded)
    highest = _MAXIMUM_DEGREES if last > HIGHEST_DEGREES else _crossing(torques, last, last - 1, demanded)
    return _Feasible(speed, lowest, highest)


def _crossing(torques: NDArray[np.float64], outside: int, inside: int, demanded: float) -> float:
    share = (demanded - torques[outside]) / (torques[inside] - torques[outside])
    return float(outside + share * (inside - outside))


def _least_line(ranges: list[_Feasible], base_speed: float, highest_speed: float) -> tuple[float, float]:
    """Return the angles of the best line at base speed and at the highest (deg)."""
    speeds, lowest, highest = (np.array(column) for column in zip(*ranges, strict=True))
    ends = [(span.speed, angle) for span in ranges for angle in (span.lowest, span.highest)]
    # The line itself must be between 0 and 90 degrees.
    ends += [(speed, angle) for speed in (base_speed, highest_speed) for angle in (0.0, _MAXIMUM_DEGREES)]
    rated: list[tuple[float, float, float, float, float]] = []
    for (one, first), (other, second) in combinations(ends, 2):
        if one == other:
            continue
        slope = (second - first) / (other - one)
        start, end = first + slope * (base_speed - one), first + slope * (highest_speed - one)
        if not (min(start, end) >= -_SAME and max(start, end) <= _MAXIMUM_DEGREES + _SAME):
            continue
        line = start + slope * (speeds - base_speed)
        outside = np.maximum(lowest - line, 0.0) + np.maximum(line - highest, 0.0)
        outside[outside < _SAME] = 0.0
        # Lines with the same mean differ in the spread of their advance.
        costs = float(outside.sum()), round(float(line.mean()), 9), float((line * line).sum())
        rated.append((*costs, start, end))
    _, _, _, start, end = min(rated)
    return start, end
