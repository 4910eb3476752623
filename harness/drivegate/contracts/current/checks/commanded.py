"""How much of what a current sum varies by is the command's, and how much a beat of the hysteresis band's."""

from __future__ import annotations

import math
from typing import Final

from drivegate_models.loop.observation import WindowObservation

STEEPEST: Final = (1.0, 0.05)
"""Change of the current sum of an ideal regulator, as a share, by the current reference, as a share (1), and by the
advance angle (1/degree). Where currents follow their reference they are in proportion to it, and few steady states are
steeper."""


def commanded_spread(values: WindowObservation) -> float:
    """Return by how much the means of the current sum vary in a window as far as current reference and angle move them.

    Where few pulses of the hysteresis band fit in a half-wave, their number beats with the means, and the current sum
    of a constant command varies by percents. What the command moves is what a line in both fits, no steeper than that
    of an ideal regulator.

    Parameters
    ----------
    values : WindowObservation
        What was observed in the window, with its means, shape (n, 3).

    Returns
    -------
    float
        Range of the line, at most that of the means (A).
    """
    varied = values.current_sum_range
    if values.reference <= 0.0 or varied <= 0.0:
        return varied
    sums, references, angles = (_deviations(column) for column in values.means.T.tolist())
    moved = (
        [values.current_sum * reference / values.reference for reference in references],
        [values.current_sum * math.degrees(angle) for angle in angles],
    )
    by_reference, by_angle = _slopes(sums, *moved)
    line = [by_reference * first + by_angle * second for first, second in zip(*moved, strict=True)]
    return min(varied, max(line) - min(line))


def _deviations(values: list[float]) -> list[float]:
    mean = math.fsum(values) / len(values)
    return [value - mean for value in values]


def _slopes(sums: list[float], references: list[float], angles: list[float]) -> tuple[float, float]:
    """Fit the slopes of a line by least squares, the first from 0 to the steepest one and the second of either sign.

    More reference is never less current; an angle further on may be either. In operations that every processor rounds
    in the same way, as those of a linear algebra library are not.
    """
    of_reference, of_angle = _product(references, references), _product(angles, angles)
    common = _product(references, angles)
    to_reference, to_angle = _product(sums, references), _product(sums, angles)
    steepest, either = STEEPEST
    determinant = of_reference * of_angle - common * common
    if determinant > 0.0:
        free = (
            (to_reference * of_angle - to_angle * common) / determinant,
            (to_angle * of_reference - to_reference * common) / determinant,
        )
        if 0.0 <= free[0] <= steepest and abs(free[1]) <= either:
            return free

    def unexplained(slopes: tuple[float, float]) -> float:
        first, second = slopes
        return (
            first * first * of_reference
            + second * second * of_angle
            + 2.0 * (first * second * common - first * to_reference - second * to_angle)
        )

    # The error has one minimum, which then lies on the border.
    border = [
        (first, _within(to_angle - first * common, of_angle, -either, either)) for first in (0.0, steepest)
    ]
    border += [
        (_within(to_reference - second * common, of_reference, 0.0, steepest), second)
        for second in (-either, either)
    ]
    return min(border, key=unexplained)


def _product(first: list[float], second: list[float]) -> float:
    return math.fsum(one * other for one, other in zip(first, second, strict=True))


def _within(numerator: float, denominator: float, lowest: float, highest: float) -> float:
    """Return a slope within its bounds; 0 where nothing moves by which it could be known."""
    return min(max(numerator / denominator, lowest), highest) if denominator > 0.0 else 0.0
