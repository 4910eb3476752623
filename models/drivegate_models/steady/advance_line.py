"""The line of initial advance angles (paper, Fig. 3) that a drive's own feasible angles lead to.

The paper chooses the slope "in such a way that constant power operation can be guaranteed over the desired
high speed range", from an angle of zero at base speed. Such a line need not exist, so here its beginning is
free, too: of all straight lines that keep rated power with some torque in hand from base speed to the highest
speed, the one with the least advance.
"""

from __future__ import annotations

from itertools import combinations
from math import nan, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.steady.plant import AnyDrive
from drivegate_models.steady.torque_limit import HIGHEST_DEGREES, torques_at_limit

RESERVE: float = 0.05
"""Torque that the line has in hand where the drive can give it, over rated torque (1)."""
SPEEDS: int = 21
"""Speeds from base to highest at which the line is held against the feasible angles."""

_FEWEST_SPEEDS = 2
_MOST = float(HIGHEST_DEGREES)
_SAME = 1e-9


class AdvanceLine(NamedTuple):
    """A straight line of advance angles above base speed; NaN where rated power is out of reach throughout."""

    base_speed: float
    """Speed at which it begins (rad/s); there is no advance below."""
    start: float
    """Angle there (rad electrical)."""
    slope: float
    """Its growth with speed (rad electrical a rad/s)."""

    def angle(self, speed: float) -> float:
        """Return the advance angle at a speed (rad/s), 0 to a quarter cycle (rad electrical)."""
        if speed < self.base_speed:
            return 0.0
        return min(max(self.start + self.slope * (speed - self.base_speed), 0.0), radians(HIGHEST_DEGREES))


class _Feasible(NamedTuple):
    """The feasible angles at a speed."""

    speed: float
    """(rad/s)."""
    lowest: float
    """(deg)."""
    highest: float
    """(deg)."""


def demanded_torque(drive: AnyDrive, speed: float, base_speed: float, rated_power: float) -> float:
    """Return the electromagnetic torque of rated power: constant up to base speed, of constant power above.

    Parameters
    ----------
    drive : AnyDrive
        The drive; the shaft's friction is added to what the power takes.
    speed : float
        Shaft speed (rad/s), above 0.
    base_speed : float
        Base speed (rad/s).
    rated_power : float
        Rated power (W).

    Returns
    -------
    float
        Torque (N m). The core loss's drag on the shaft is not in it, as nowhere in the oracle.
    """
    return rated_power / max(speed, base_speed) + drive.friction + drive.viscous_friction * speed


def recommended_line(
    drive: AnyDrive, base_speed: float, highest_speed: float, rated_power: float
) -> AdvanceLine:
    """Return the line of least advance that keeps rated power from base speed to the highest.

    At each of `SPEEDS` speeds the angles count that give `RESERVE` more than rated torque at the current limit,
    or half of what the drive can give beyond rated torque where that is less: those around the angle of the
    greatest torque, from a grid of 1 degree with straight lines between. Speeds at which rated torque is out
    of reach do not count. The best line always passes through two of the ends of these ranges, so all
    such lines are compared: first by how far they leave the ranges (not at all where a line can be had),
    then by their mean angle.

    Parameters
    ----------
    drive : AnyDrive
        The drive, taken with its band as it is.
    base_speed, highest_speed : float
        Speeds between which power is to be constant (rad/s), the first below the second.
    rated_power : float
        Rated power (W).

    Returns
    -------
    AdvanceLine
        With both of its ends rounded to 0.1 degree.
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
    """Return the angles around that of the greatest torque that give what is demanded; none where none does."""
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
    highest = _MOST if last > HIGHEST_DEGREES else _crossing(torques, last, last - 1, demanded)
    return _Feasible(speed, lowest, highest)


def _crossing(torques: NDArray[np.float64], outside: int, inside: int, demanded: float) -> float:
    share = (demanded - torques[outside]) / (torques[inside] - torques[outside])
    return float(outside + share * (inside - outside))


def _least_line(ranges: list[_Feasible], base_speed: float, highest_speed: float) -> tuple[float, float]:
    """Return the angles of the best line at base speed and at the highest (deg)."""
    speeds, lowest, highest = (np.array(column) for column in zip(*ranges, strict=True))
    ends = [(span.speed, angle) for span in ranges for angle in (span.lowest, span.highest)]
    # The line itself stays within the angles that there are.
    ends += [(speed, angle) for speed in (base_speed, highest_speed) for angle in (0.0, _MOST)]
    rated: list[tuple[float, float, float, float, float]] = []
    for (one, first), (other, second) in combinations(ends, 2):
        if one == other:
            continue
        slope = (second - first) / (other - one)
        start, end = first + slope * (base_speed - one), first + slope * (highest_speed - one)
        if not (min(start, end) >= -_SAME and max(start, end) <= _MOST + _SAME):
            continue
        line = start + slope * (speeds - base_speed)
        outside = np.maximum(lowest - line, 0.0) + np.maximum(line - highest, 0.0)
        outside[outside < _SAME] = 0.0
        # Lines of the same mean differ in how evenly their advance is spread.
        costs = float(outside.sum()), round(float(line.mean()), 9), float((line * line).sum())
        rated.append((*costs, start, end))
    _, _, _, start, end = min(rated)
    return start, end
