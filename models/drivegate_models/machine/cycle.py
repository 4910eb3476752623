"""Position of a phase in its electrical cycle: the piece of the back-EMF shape, and the conduction window."""

from __future__ import annotations

from math import floor, inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined


@inlined
def wrapped(angle: float) -> float:
    """Return an angle minus whole turns, in [0, 2 pi) (rad)."""
    turns = floor(angle * (0.5 / pi))
    return max(angle - 2.0 * pi * turns, 0.0)


@inlined
def within_half_turn(angle: float) -> float:
    """Return an angle minus whole turns, in [-pi, pi) (rad)."""
    return angle - 2.0 * pi * floor(angle / (2.0 * pi) + 0.5)


class Shape(NamedTuple):
    """The present linear piece of a phase's back-EMF shape; times are from the beginning of the advance (s)."""

    corner: int
    """Index of the piece's first corner."""
    turn: float
    """Angle from the phase's initial angle to the start of that corner's cycle (rad)."""
    begin: float
    end: float
    start: float
    """Shape at `begin` (1)."""
    rate: float
    """Rate of the shape (1/s)."""


class ConductionWindow(NamedTuple):
    """The present conduction window of a phase, or the gap after it."""

    sector: int
    """1, -1, or 0 between windows."""
    following: int
    """The next window, in a gap between windows."""
    end: float
    """End of the window or gap, from the beginning of the advance (s)."""


@inlined
def _corner_before(corners: NDArray[np.float64], angle: float) -> int:
    """Return the index of the corner at or before an angle, by bisection."""
    low = 0
    high = corners.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if corners[middle] <= angle:
            low = middle
        else:
            high = middle
    return low


@inlined
def shape_at(
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    angle: float,
    electrical: float,
) -> Shape:
    """Return the piece of the back-EMF shape at an angle at time zero.

    `corners`, `corner_values`, `corner_slopes`: the drive's `emf_angles`, `emf_values` and `emf_slopes`. `angle`:
    electrical angle in [0, 2 pi) (rad). `electrical`: electrical speed (rad/s); 0 at standstill, where the piece has an
    infinite end.
    """
    corner = _corner_before(corners, angle)
    if electrical == 0.0:
        value = corner_values[corner] + corner_slopes[corner] * (angle - corners[corner])
        return Shape(corner, -angle, 0.0, inf, value, corner_slopes[corner] * electrical)
    per_radian = 1.0 / electrical
    return Shape(
        corner,
        -angle,
        (corners[corner] + -angle) * per_radian,
        (corners[corner + 1] + -angle) * per_radian,
        corner_values[corner],
        corner_slopes[corner] * electrical,
    )


@inlined
def next_shape(
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    shape: Shape,
    electrical: float,
) -> Shape:
    """Return the piece of the back-EMF shape after another one.

    `corners`, `corner_values`, `corner_slopes`: the drive's `emf_angles`, `emf_values` and `emf_slopes`. `electrical`:
    electrical speed (rad/s), above 0. Result: in the next cycle after the last corner.
    """
    per_radian = 1.0 / electrical
    corner = shape.corner + 1
    turn = shape.turn
    if corner > corners.size - 2:
        corner = 0
        turn += 2.0 * pi
    return Shape(
        corner,
        turn,
        (corners[corner] + turn) * per_radian,
        (corners[corner + 1] + turn) * per_radian,
        corner_values[corner],
        corner_slopes[corner] * electrical,
    )


@inlined
def window_at(angle: float, width: float, electrical: float) -> ConductionWindow:
    """Return the conduction window at an angle at time zero.

    `angle`: electrical angle, advance included (rad). `width`: width of each window (rad). `electrical`: electrical
    speed (rad/s); 0 at standstill, where the window has an infinite end.
    """
    per_radian = 1.0 / electrical if electrical > 0.0 else inf
    position = wrapped(angle - 0.5 * (pi - width))
    if position < width:
        sector, to_edge, following = 1, width - position, -1
    elif position < pi:
        sector, to_edge, following = 0, pi - position, -1
    elif position < pi + width:
        sector, to_edge, following = -1, pi + width - position, 1
    else:
        sector, to_edge, following = 0, 2.0 * pi - position, 1
    return ConductionWindow(sector, following, to_edge * per_radian if electrical > 0.0 else inf)


@inlined
def next_window(window: ConductionWindow, width: float, electrical: float) -> ConductionWindow:
    """Return the gap after a window, or the window after a gap.

    `width`: width of each window (rad). `electrical`: electrical speed (rad/s), above 0.
    """
    per_radian = 1.0 / electrical
    if window.sector != 0:
        return ConductionWindow(0, -window.sector, window.end + (pi - width) * per_radian)
    return ConductionWindow(window.following, window.following, window.end + width * per_radian)
