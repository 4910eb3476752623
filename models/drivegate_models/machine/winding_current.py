"""The current of one winding between two events, in closed form.

Between events the terminal voltage v is constant and the back-EMF is a straight line in time, so that
``L di/dt = v - R i - e(t)`` has the solution::

    i(t) = i0 + g0 t phi1(x) - a t**2 phi2(x),    x = R t / L,   a = (de/dt) / L,

with ``g0 = di/dt`` at the start and ``phi_k(x) = sum_n (-x)**n / (n + k)!`` (the phi functions of exponential
integrators). In this form nothing cancels when the resistance is small, and R = 0 is no special case.
Intervals are kept to ``x <= LONGEST`` by their callers, where the truncated series are exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial, inf
from typing import NamedTuple

import numpy as np

from drivegate_models.compilation.kernels import inlined, kernel
from drivegate_models.machine.logarithm import GREATEST, logarithm_ratio

LONGEST = 0.5
"""Longest interval, as a multiple of the time constant L/R, for which the series are used."""

# Chops are far shorter than L/R: seven terms are exact to rounding up to x = 1/64, seventeen up to 1/2.
_SHORT = 1.0 / 64.0
_SHORT_TERMS = 7
_ALL_TERMS = 17


def _phi4_term(k: int) -> float:
    return 1.0 / factorial(k + 4)


# Integrals of the squares of t phi1 and t**2 phi2, and of their product, as series of their own: the closed
# forms in exponentials cancel when the resistance is small.


def _square_11_term(k: int) -> float:
    return float((2 ** (k + 2) - 2) / factorial(k + 3))


def _square_12_term(k: int) -> float:
    return float((2 ** (k + 3) - 2) / factorial(k + 4) - 1.0 / (factorial(k + 2) * (k + 4)))


def _square_22_term(k: int) -> float:
    return float((2 ** (k + 4) - 2) / factorial(k + 5) - 2.0 / (factorial(k + 3) * (k + 5)))


def _polynomial(term: Callable[[int], float]) -> Callable[[float], float]:
    """Return ``sum_k term(k) (-x)**k`` compiled, with few terms for the short intervals that are the rule."""
    coefficients = tuple(term(k) * (-1.0 if k % 2 else 1.0) for k in range(_ALL_TERMS))
    c0, c1, c2, c3, c4, c5, c6 = coefficients[:_SHORT_TERMS]

    def evaluate(x: float) -> float:
        if x <= _SHORT:
            # In pairs, so that one product need not wait for the other.
            square = x * x
            fourth = square * square
            return ((c0 + c1 * x) + square * (c2 + c3 * x)) + fourth * ((c4 + c5 * x) + square * c6)
        total = 0.0
        for k in range(_ALL_TERMS - 1, -1, -1):
            total = total * x + coefficients[k]
        return total

    return inlined(evaluate)


phi4 = _polynomial(_phi4_term)
"""The phi function of order four; lower orders follow from ``phi_k = 1/k! - x phi_(k+1)``."""
_square_11 = _polynomial(_square_11_term)
_square_12 = _polynomial(_square_12_term)
_square_22 = _polynomial(_square_22_term)


class Phis(NamedTuple):
    """The phi functions of one time; windings of one R/L share them."""

    x: float
    """R t / L (1)."""
    first: float
    second: float
    third: float
    fourth: float


@inlined
def phis_at(x: float) -> Phis:
    """Return the phi functions of orders one to four.

    Parameters
    ----------
    x : float
        R t / L, at most `LONGEST`.

    Returns
    -------
    Phis
        Written so that little waits for phi4.
    """
    square = x * x
    p4 = phi4(x)
    return Phis(
        x,
        (1.0 - x * (0.5 - x * (1.0 / 6.0))) - (x * square) * p4,
        (0.5 - x * (1.0 / 6.0)) + square * p4,
        1.0 / 6.0 - x * p4,
        p4,
    )


@inlined
def current_by(start: float, slope: float, curvature: float, time: float, phis: Phis) -> tuple[float, float]:
    """Return the current and its slope as `current_after` does, by phi functions that are known already.

    Parameters
    ----------
    start, slope, curvature, time : float
        As in `current_after`.
    phis : Phis
        Those of the time.

    Returns
    -------
    current, slope : float
        (A), (A/s).
    """
    current = start + time * (slope * phis.first - curvature * time * phis.second)
    return current, slope * (1.0 - phis.x * phis.first) - curvature * time * phis.first


@inlined
def current_after(
    start: float, slope: float, curvature: float, rate: float, time: float
) -> tuple[float, float]:
    """Return the current and its slope after a time.

    Parameters
    ----------
    start : float
        Current i0 at the interval's start (A).
    slope : float
        Its slope g0 there (A/s).
    curvature : float
        Slope of the back-EMF over the inductance, a (A/s2).
    rate : float
        R/L (1/s).
    time : float
        Time from the interval's start (s).

    Returns
    -------
    current : float
        (A).
    slope : float
        (A/s).
    """
    return current_by(start, slope, curvature, time, phis_at(rate * time))


@inlined
def turning_time(slope: float, curvature: float, rate: float) -> float:
    """Return when the current's slope passes zero, or infinity where it does not within the longest interval.

    Parameters
    ----------
    slope, curvature, rate : float
        As in `current_after`.

    Returns
    -------
    float
        The only zero of ``g0 exp(-rate t) - a (1 - exp(-rate t))/rate`` at t > 0 (s).
    """
    if slope == 0.0 or curvature == 0.0 or (slope > 0.0) != (curvature > 0.0):
        return inf
    ratio = slope / curvature
    x = rate * ratio
    # The slope is zero after ln(1 + x) / rate; of greater x that is more than LONGEST / rate.
    return ratio * logarithm_ratio(x) if x <= GREATEST else inf


@kernel
def _root(
    start: float,
    slope: float,
    curvature: float,
    rate: float,
    level: float,
    low: float,
    high: float,
    rising: bool,
) -> float:
    """Return the root of i(t) = level in the bracket [low, high] in which i is monotone (s)."""
    sign = 1.0 if rising else -1.0
    low_limit = low
    high_limit = high
    gap = level - start
    bending = curvature + rate * slope
    discriminant = slope * slope - 2.0 * bending * gap
    time = 0.5 * (low + high)
    if discriminant >= 0.0:
        # The parabola that leaves the start with the current's slope and curvature.
        square = np.sqrt(discriminant)
        # The form of the quadratic formula that adds numbers of one sign only.
        divisor = slope + (square if slope >= 0.0 else -square)
        first = 2.0 * gap / divisor if divisor != 0.0 else -1.0
        second = divisor / bending if bending != 0.0 else -1.0
        if low <= first <= high:
            time = first
        elif low <= second <= high:
            time = second
    for _ in range(200):
        current, current_slope = current_after(start, slope, curvature, rate, time)
        error = current - level
        if error == 0.0:
            return time
        if sign * error > 0.0:
            high_limit = time
        else:
            low_limit = time
        step = error / current_slope if current_slope != 0.0 else inf
        # Newton's next error is this step times the share by which the slope changes over it.
        bend = (abs(curvature) + rate * abs(current_slope)) * abs(step)
        if abs(step) * bend <= 2e-16 * high * abs(current_slope) or abs(step) <= 2e-16 * high:
            return min(max(time - step, low), high)
        following = time - step
        # Halving cannot fail where Newton leaves the bracket.
        if not (low_limit < following < high_limit):
            following = 0.5 * (low_limit + high_limit)
            if following in (low_limit, high_limit):
                # The far side of two neighbouring floats: there the level has been reached.
                return high_limit
        time = following
    return time


@inlined
def crossing_time(
    start: float,
    slope: float,
    curvature: float,
    rate: float,
    end: float,
    end_current: float,
    end_slope: float,
    level: float,
    rising: bool,
) -> float:
    """Return the first time in (0, end] at which the current reaches a level from one side.

    Parameters
    ----------
    start, slope, curvature, rate : float
        As in `current_after`; the start lies on the level's near side, or on the level itself.
    end : float
        End of the interval (s).
    end_current, end_slope : float
        Current (A) and slope (A/s) there.
    level : float
        The level (A).
    rising : bool
        Whether the level lies above the near side.

    Returns
    -------
    float
        The time (s), or infinity where the level is not reached. A current that starts on the level and
        leaves toward the near side reaches it when it comes back.

    Notes
    -----
    The slope has one zero at most, so the current has two monotone pieces at most and no crossing between
    two looks can be missed.
    """
    sign = 1.0 if rising else -1.0
    approaching = sign * slope > 0.0 or (slope == 0.0 and sign * curvature < 0.0)
    reached_at_end = sign * (end_current - level) >= 0.0
    if approaching:
        if start == level:
            return 0.0
        if sign * end_slope >= 0.0:
            if not reached_at_end:
                return inf
            return _root(start, slope, curvature, rate, level, 0.0, end, rising)
        # Up to the turn only: a current that comes back has met the level before.
        turn = min(turning_time(slope, curvature, rate), end)
        if not reached_at_end:
            # The end lies short of the level, so the turn alone can have reached it.
            peak, _ = current_after(start, slope, curvature, rate, turn)
            if sign * (peak - level) < 0.0:
                return inf
        return _root(start, slope, curvature, rate, level, 0.0, turn, rising)
    if not reached_at_end:
        return inf
    turn = turning_time(slope, curvature, rate)
    if turn >= end:
        # Flat or leaving throughout: a level met at the end is met by rounding alone.
        return end if start != level else inf
    return _root(start, slope, curvature, rate, level, turn, end, rising)


class Squares(NamedTuple):
    """The series of one time in the integral of the squared current; windings of one R/L share them."""

    slope: float
    mixed: float
    curvature: float


@inlined
def squares_at(x: float) -> Squares:
    """Return the series of R t / L that weigh squared slope, slope times curvature, and squared curvature."""
    return Squares(_square_11(x), _square_12(x), _square_22(x))


@inlined
def integrals_by(
    start: float, slope: float, curvature: float, time: float, phis: Phis, squares: Squares
) -> tuple[float, float, float, float, float]:
    """Return the current and its integrals as `current_integrals` does, by series that are known already.

    Parameters
    ----------
    start, slope, curvature, time : float
        As in `current_integrals`.
    phis : Phis
        Those of the time.
    squares : Squares
        Those of the time.

    Returns
    -------
    end, end_slope, first, second, square : float
        As from `current_integrals`.
    """
    rise = slope * time
    bend = curvature * time * time
    end = start + rise * phis.first - bend * phis.second
    end_slope = slope * (1.0 - phis.x * phis.first) - curvature * time * phis.first
    first = time * (start + rise * phis.second - bend * phis.third)
    second = time * time * (0.5 * start + rise * phis.third - bend * phis.fourth)
    square = time * (
        start * (start + 2.0 * (rise * phis.second - bend * phis.third))
        + rise * (rise * squares.slope - 2.0 * bend * squares.mixed)
        + bend * bend * squares.curvature
    )
    return end, end_slope, first, second, square


@inlined
def current_integrals(
    start: float, slope: float, curvature: float, rate: float, time: float
) -> tuple[float, float, float, float, float]:
    """Return the current at the end of an interval and its exact integrals over it.

    Parameters
    ----------
    start, slope, curvature, rate : float
        As in `current_after`.
    time : float
        Length of the interval (s), at most LONGEST / rate.

    Returns
    -------
    end : float
        Current at the end (A).
    end_slope : float
        Its slope there (A/s).
    first : float
        Integral of i (A s).
    second : float
        Integral of the integral of i, the double integral from the start (A s2).
    square : float
        Integral of i**2 (A2 s).
    """
    x = rate * time
    return integrals_by(start, slope, curvature, time, phis_at(x), squares_at(x))
