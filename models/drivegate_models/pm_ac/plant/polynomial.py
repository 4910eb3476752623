"""First fall of a polynomial below zero on [0, 1], and its extremes there, without missing any.

Coefficients are in ascending order. A parabola below the polynomial, from its value, its slope and a bound of its
curvature, leads to the first zero from the left. It never steps over a zero, and converges like Newton's method.
"""

from __future__ import annotations

from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating

NOWHERE: Final = 2.0
"""Result without a place in [0, 1]."""

_LOOKS = 10_000
_REACHED = 0.25
_ROUNDING = 1e-15
_LEAP = 1e-7


@inlined
def value_at(series: NDArray[np.float64], count: int, at: float) -> float:
    """Return the value of a polynomial with `count` coefficients at a place, in the unit of the coefficients."""
    value = 0.0
    for k in range(count - 1, -1, -1):
        value = value * at + series[k]
    return value


@inlined
def integral_to(series: NDArray[np.float64], count: int, at: float) -> float:
    """Return the integral of a polynomial with `count` coefficients from 0 to a place, in their unit."""
    value = 0.0
    for k in range(count - 1, -1, -1):
        value = value * at + series[k] / (k + 1)
    return value * at


@inlined
def size_of(series: NDArray[np.float64], count: int) -> float:
    """Return the sum of the magnitudes of the coefficients, which bounds the polynomial on [0, 1]."""
    size = 0.0
    for k in range(count):
        size += abs(series[k])
    return size


@inlined
def _parabola_step(value: float, slope: float, curvature: float) -> float:
    """Return the distance over which a parabola with downward curvature remains above zero."""
    root = sqrt(slope * slope + 2.0 * curvature * value)
    if slope < 0.0:
        return 2.0 * value / (root - slope)
    return (slope + root) / curvature if curvature > 0.0 else NOWHERE


@unallocating
def first_fall(series: NDArray[np.float64], count: int, sign: float, start: float, slack: float) -> float:
    """Return the place at which a polynomial, times a sign, first falls below zero by a slack.

    - `series`, shape (n,): coefficients in ascending order.
    - `count`: number of coefficients.
    - `sign`: 1 or -1.
    - `start`: start of the search, in [0, 1].
    - `slack`: minimum distance below zero, above 0 (unit of the coefficients).
    - Result: place in [start, 1], with a value between -slack and -3/4 slack unless it was below that at the start;
      `NOWHERE` if there is none.
    """
    least = sign * series[0] + slack
    curvature = 0.0
    for k in range(1, count):
        least += min(sign * series[k], 0.0)
        curvature += k * (k - 1) * abs(series[k])
    if least > 0.0:
        return NOWHERE
    at = start
    for _ in range(_LOOKS):
        value = 0.0
        slope = 0.0
        for k in range(count - 1, -1, -1):
            slope = slope * at + value
            value = value * at + series[k]
        value = sign * value + slack
        if value <= _REACHED * slack:
            return at
        following = at + _parabola_step(value, sign * slope, curvature)
        if following > 1.0:
            return NOWHERE
        if following <= at:
            return at
        at = following
    return at


@unallocating
def extremes(series: NDArray[np.float64], count: int, slopes: NDArray[np.float64]) -> tuple[float, float]:
    """Return minimum and maximum of a polynomial on [0, 1].

    `series`, shape (n,): coefficients in ascending order. `count`: number of coefficients. `slopes`, shape (n,): work
    space for the derivative. Returns `lowest`, `highest`: extremes in the unit of the coefficients, exact to rounding.
    """
    end = value_at(series, count, 1.0)
    lowest = min(series[0], end)
    highest = max(series[0], end)
    for k in range(1, count):
        slopes[k - 1] = k * series[k]
    slack = _ROUNDING * size_of(slopes, count - 1)
    at = 0.0
    leap = _LEAP
    while at < 1.0 and slack > 0.0:
        slope = value_at(slopes, count - 1, at)
        if abs(slope) > slack:
            at = first_fall(slopes, count - 1, 1.0 if slope > 0.0 else -1.0, at, slack)
            if at > 1.0:
                break
        value = value_at(series, count, at)
        lowest = min(lowest, value)
        highest = max(highest, value)
        # Step past a stationary point, whose neighbourhood differs from it by less than rounding.
        at += leap
        leap *= 2.0
    return lowest, highest
