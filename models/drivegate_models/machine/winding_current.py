"""The current of one winding between two events, in closed form.

Between events the terminal voltage v is constant and the back-EMF is linear in time, so that
``L di/dt = v - R i - e(t)`` has the solution::

    i(t) = i0 + g0 t phi1(x) - a t**2 phi2(x),    x = R t / L,   a = (de/dt) / L,

with ``g0 = di/dt`` at the start and ``phi_k(x) = sum_n (-x)**n / (n + k)!`` (the phi functions of exponential
integrators). This form has no cancellation for a small resistance, and R = 0 is no special case. Callers limit
intervals to ``x <= LONGEST``, where the truncated series are exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial, inf
from typing import Final, NamedTuple

import numpy as np

from drivegate_models.compilation.kernels import inlined, unallocating

GREATEST: Final = 0.65
"""Maximum argument for which the series is exact to rounding."""

# With s = x / (2 + x): ln(1 + x) = 2 artanh s = 2 s + s R, R = 2 s**2/3 + 2 s**4/5 + ..., and 2 s = x - s x.
_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = (2.0 / (2 * k + 3) for k in range(12))
LONGEST = 0.5
"""Longest interval, as a multiple of the time constant L/R, for which the series are used."""

# Chops are far shorter than L/R: seven terms are exact to rounding up to x = 1/64, seventeen up to 1/2.
_SHORT = 1.0 / 64.0
_SHORT_TERMS = 7
_ALL_TERMS = 17


def _polynomial(term: Callable[[int], float]) -> Callable[[float], float]:
    """Return the compiled function ``sum_k term(k) (-x)**k``, with few terms for the common short intervals."""
    coefficients = tuple(term(k) * (-1.0 if k % 2 else 1.0) for k in range(_ALL_TERMS))
    c0, c1, c2, c3, c4, c5, c6 = coefficients[:_SHORT_TERMS]

    def evaluate(x: float) -> float:
        if x <= _SHORT:
            # In pairs, so that one product does not wait for the other.
            square = x * x
            fourth = square * square
            return ((c0 + c1 * x) + square * (c2 + c3 * x)) + fourth * ((c4 + c5 * x) + square * c6)
        total = 0.0
        for k in range(_ALL_TERMS - 1, -1, -1):
            total = total * x + coefficients[k]
        return total

    return inlined(evaluate)


phi4 = _polynomial(lambda k: 1.0 / factorial(k + 4))
"""The phi function of order four; lower orders follow from ``phi_k = 1/k! - x phi_(k+1)``."""
# Integrals of the squares of t phi1 and t**2 phi2, and of their product, as separate series: the closed forms with
# exponentials suffer cancellation for a small resistance.
_square_11 = _polynomial(lambda k: (2 ** (k + 2) - 2) / factorial(k + 3))
_square_12 = _polynomial(lambda k: (2 ** (k + 3) - 2) / factorial(k + 4) - 1.0 / (factorial(k + 2) * (k + 4)))
_square_22 = _polynomial(lambda k: (2 ** (k + 4) - 2) / factorial(k + 5) - 2.0 / (factorial(k + 3) * (k + 5)))


class Phis(NamedTuple):
    """The phi functions of one time, common to windings with the same R/L."""

    x: float
    """R t / L (1)."""
    first: float
    second: float
    third: float
    fourth: float


@inlined
def phis_at(x: float) -> Phis:
    """Return the phi functions of orders one to four, computed in an order with few dependencies on phi4.

    `x`: R t / L, at most `LONGEST` (1).
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
    """Return the current (A) and its slope (A/s), from phi functions that are already known.

    The other arguments are those of `current_after`.
    """
    current = start + time * (slope * phis.first - curvature * time * phis.second)
    return current, slope * (1.0 - phis.x * phis.first) - curvature * time * phis.first


@inlined
def current_after(
    start: float, slope: float, curvature: float, rate: float, time: float
) -> tuple[float, float]:
    """Return the current and its slope after a time.

    `start`, `slope`: current i0 (A) and its slope g0 (A/s) at the interval's start. `curvature`: slope of the back-EMF
    over the inductance, a (A/s2). `rate`: R/L (1/s). `time`: time from the interval's start (s). Returns `current`,
    `slope`: both at that time (A, A/s).
    """
    return current_by(start, slope, curvature, time, phis_at(rate * time))


@inlined
def turning_time(slope: float, curvature: float, rate: float) -> float:
    """Return the time at which the current's slope passes zero, or infinity if not within the longest interval.

    `slope`, `curvature`, `rate`: arguments of `current_after`. Result: the only zero at t > 0 (s) of
    ``g0 exp(-rate t) - a (1 - exp(-rate t))/rate``.
    """
    if slope == 0.0 or curvature == 0.0 or (slope > 0.0) != (curvature > 0.0):
        return inf
    ratio = slope / curvature
    x = rate * ratio
    # The slope is zero after ln(1 + x) / rate, which exceeds LONGEST / rate for greater x.
    return ratio * logarithm_ratio(x) if x <= GREATEST else inf


@unallocating
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
    """Return the root of i(t) = level (s) in the bracket [low, high], in which i is monotone."""
    sign = 1.0 if rising else -1.0
    low_limit = low
    high_limit = high
    gap = level - start
    bending = curvature + rate * slope
    discriminant = slope * slope - 2.0 * bending * gap
    time = 0.5 * (low + high)
    if discriminant >= 0.0:
        # Initial value from the parabola with the current's slope and curvature at the start.
        square = np.sqrt(discriminant)
        # This form of the quadratic formula adds only numbers of the same sign.
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
        # Newton's next error is this step times the relative change of the slope over it.
        bend = (abs(curvature) + rate * abs(current_slope)) * abs(step)
        if abs(step) * bend <= 2e-16 * high * abs(current_slope) or abs(step) <= 2e-16 * high:
            return min(max(time - step, low), high)
        following = time - step
        # Where Newton leaves the bracket, halving cannot fail.
        if not (low_limit < following < high_limit):
            following = 0.5 * (low_limit + high_limit)
            if following in (low_limit, high_limit):
                # Of two neighbouring floats, return the one at which the level has been reached.
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

    The slope has at most one zero, so the current has at most two monotone pieces and no crossing is missed.

    - `start`, `slope`, `curvature`, `rate`: arguments of `current_after`; the start is on the level's near side, or on
      the level itself.
    - `end`, `end_current`, `end_slope`: end of the interval (s), current (A) and slope (A/s) there.
    - `level`: level of the event (A).
    - `rising`: true if the level is above the near side.
    - Result: time of the event (s), or infinity if the level is not reached. A current that starts on the level and
      leaves toward the near side reaches it when it returns.
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
        # Search only up to the turning point: a current that returns has reached the level before.
        turn = min(turning_time(slope, curvature, rate), end)
        if not reached_at_end:
            # The end is before the level, so only the turning point can have reached it.
            peak, _ = current_after(start, slope, curvature, rate, turn)
            if sign * (peak - level) < 0.0:
                return inf
        return _root(start, slope, curvature, rate, level, 0.0, turn, rising)
    if not reached_at_end:
        return inf
    turn = turning_time(slope, curvature, rate)
    if turn >= end:
        # The current is constant or leaves throughout: it reaches a level at the end only by rounding.
        return end if start != level else inf
    return _root(start, slope, curvature, rate, level, turn, end, rising)


class Squares(NamedTuple):
    """The series of one time for the integral of the squared current, common to windings with the same R/L."""

    slope: float
    mixed: float
    curvature: float


@inlined
def squares_at(x: float) -> Squares:
    """Return the series of x = R t / L for squared slope, slope times curvature, and squared curvature."""
    return Squares(_square_11(x), _square_12(x), _square_22(x))


@inlined
def integrals_by(
    start: float, slope: float, curvature: float, time: float, phis: Phis, squares: Squares
) -> tuple[float, float, float, float, float]:
    """Return the results of `current_integrals`, from series that are already known.

    `phis` and `squares` are the series at the time; the other arguments are those of `current_integrals`.
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

    `start`, `slope`, `curvature`, `rate`: arguments of `current_after`. `time`: length of the interval (s), at most
    LONGEST / rate. Returns `end`, `end_slope`: current (A) and slope (A/s) at the end; `first`: integral of i (A s);
    `second`: double integral of i from the start (A s2); `square`: integral of i**2 (A2 s).
    """
    x = rate * time
    return integrals_by(start, slope, curvature, time, phis_at(x), squares_at(x))


@inlined
def logarithm_ratio(x: float) -> float:
    """Return ``ln(1 + x) / x``, which is 1 at zero, within one unit in the last place.

    Every processor rounds its operations identically; the logarithms of libraries differ.

    The argument is from 0 to `GREATEST`. ``ln(1 + x) = x - s (x - R)`` as in fdlibm, divided by x: the correction
    to 1 is at most a quarter, so its own rounding is negligible. The series ends where its next term is below
    1e-17.
    """
    divisor = 2.0 + x
    share = x / divisor
    z = share * share
    z2 = z * z
    z4 = z2 * z2
    low = (_C0 + _C1 * z) + z2 * (_C2 + _C3 * z)
    middle = (_C4 + _C5 * z) + z2 * (_C6 + _C7 * z)
    high = (_C8 + _C9 * z) + z2 * (_C10 + _C11 * z)
    series = z * (low + z4 * (middle + z4 * high))
    return 1.0 - (x - series) / divisor
