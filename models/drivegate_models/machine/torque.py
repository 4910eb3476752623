"""Exact extremes of the torque over an advance, from the segments of all phases.

Between events the torque is a polynomial of second degree plus a straight line times one exponential, so its
third derivative has one zero at most. Nested isolation from there up finds every stationary point.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine import segments
from drivegate_models.machine.winding_current import current_after, phi4

Coefficients = tuple[float, float, float, float, float, float]


@inlined
def _derivatives(coefficients: Coefficients, rate: float, time: float) -> tuple[float, float, float]:
    """Return torque over EMF constant and its first two derivatives at a time of the interval."""
    c0, c1, d0, d1, q0, q1 = coefficients
    # From phi4 downward, as in `winding_current`: upward recurrence would cancel at small R t / L.
    x = rate * time
    phi2 = 0.5 - x * (1.0 / 6.0 - x * phi4(x))
    phi1 = 1.0 - x * phi2
    decay = 1.0 - x * phi1
    p1 = time * phi1
    p2 = time * time * phi2
    value = c0 + c1 * time + (d0 + d1 * time) * p1 - (q0 + q1 * time) * p2
    first = c1 + d0 * decay + d1 * (p1 + time * decay) - q0 * p1 - q1 * (p2 + time * p1)
    second = decay * (2.0 * d1 - rate * (d0 + d1 * time) - q0 - q1 * time) - 2.0 * q1 * p1
    return value, first, second


@unallocating
def _zero(coefficients: Coefficients, rate: float, low: float, high: float, order: int) -> float:
    """Return the zero of a derivative (1 or 2) that changes sign over [low, high], by safeguarded bisection."""
    at_low = _derivatives(coefficients, rate, low)[order]
    # The chord bound below lets few intervals come this far, so plain halving is fast enough.
    for _ in range(100):
        middle = 0.5 * (low + high)
        # No float lies between any more.
        if middle in (low, high):
            break
        at_middle = _derivatives(coefficients, rate, middle)[order]
        if at_middle == 0.0:
            return middle
        if (at_middle > 0.0) == (at_low > 0.0):
            low = middle
        else:
            high = middle
    return high


@unallocating
def _interval_extremes(
    coefficients: Coefficients, rate: float, length: float, lowest: float, highest: float
) -> tuple[float, float]:
    """Widen [lowest, highest] by the torque over EMF constant on one interval without events."""
    start, start_first, start_second = _derivatives(coefficients, rate, 0.0)
    end, end_first, end_second = _derivatives(coefficients, rate, length)
    lowest = min(lowest, start, end)
    highest = max(highest, start, end)
    _, _, d0, d1, q0, q1 = coefficients
    # The only zero of the third derivative. Without resistance that derivative is a constant and has none.
    divisor = rate * (rate * d1 + q1)
    inflection = 0.0
    if divisor != 0.0:
        inflection = (3.0 * (rate * d1 + q1) - rate * (rate * d0 + q0)) / divisor
    bends = 0.0 < inflection < length
    # Then the second derivative keeps its sign, the first is monotone, and so it keeps its sign, too.
    if not bends and start_second * end_second > 0.0 and start_first * end_first > 0.0:
        return lowest, highest
    # A function departs from its chord by an eighth of its greatest second derivative times the length squared.
    steepest = max(abs(start_second), abs(end_second))
    if bends:
        steepest = max(steepest, abs(_derivatives(coefficients, rate, inflection)[2]))
    off_chord = 0.125 * steepest * length * length
    # What cannot leave the range known so far is not searched: that spares most intervals of a cycle.
    if max(start, end) + off_chord <= highest and min(start, end) - off_chord >= lowest:
        return lowest, highest

    # The second derivative is monotone on either side of the inflection, the first one between its zeros.
    previous = 0.0
    for part in range(2):
        end_of_part = inflection if part == 0 and bends else length
        if end_of_part <= previous:
            continue
        middle = end_of_part
        before = _derivatives(coefficients, rate, previous)[2]
        after = _derivatives(coefficients, rate, end_of_part)[2]
        if before * after < 0.0:
            middle = _zero(coefficients, rate, previous, end_of_part, 2)
        for low, high in ((previous, middle), (middle, end_of_part)):
            first_before = _derivatives(coefficients, rate, low)[1]
            first_after = _derivatives(coefficients, rate, high)[1]
            if first_before * first_after < 0.0:
                stationary = _zero(coefficients, rate, low, high, 1)
                value = _derivatives(coefficients, rate, stationary)[0]
                lowest = min(lowest, value)
                highest = max(highest, value)
        previous = end_of_part
    return lowest, highest


@unallocating
def torque_extremes(
    rows: NDArray[np.float64],
    row_counts: NDArray[np.int64],
    positions: NDArray[np.int64],
    emf_constant: float,
    rate: float,
    duration: float,
    lowest: float,
    highest: float,
) -> tuple[float, float]:
    """Widen a range by the torque of all phases over one advance.

    Parameters
    ----------
    rows : ndarray, shape (m, n, segments.FIELDS)
        Segments of each phase, without gaps from 0 to `duration`.
    row_counts : ndarray of int64, shape (m,)
        Number of segments of each phase.
    positions : ndarray of int64, shape (m,)
        Room for the computation.
    emf_constant : float
        Peak torque an ampere (N m/A).
    rate : float
        R/L (1/s).
    duration : float
        Length of the advance (s).
    lowest, highest : float
        Range so far (N m); start with inf and -inf.

    Returns
    -------
    lowest, highest : float
        Range including this advance (N m), at events and stationary points, not on a grid.
    """
    phases = rows.shape[0]
    positions[:] = 0
    # The common factor is divided out once, not multiplied into every evaluation.
    low = lowest / emf_constant
    high = highest / emf_constant
    time = 0.0
    while time < duration:
        until = duration
        c0 = 0.0
        c1 = 0.0
        d0 = 0.0
        d1 = 0.0
        q0 = 0.0
        q1 = 0.0
        for phase in range(phases):
            # The last segment is never passed: by rounding it may end short of the advance.
            while positions[phase] < row_counts[phase] - 1:
                row = rows[phase, positions[phase]]
                if row[segments.START] + row[segments.LENGTH] > time:
                    break
                positions[phase] += 1
            row = rows[phase, positions[phase]]
            ends = row[segments.START] + row[segments.LENGTH]
            if positions[phase] < row_counts[phase] - 1 and ends < until:
                until = ends
            offset = time - row[segments.START]
            current = row[segments.CURRENT]
            curvature = row[segments.CURVATURE]
            # Every phase is taken to the same instant, from which on the sum has six coefficients in all.
            current, slope = current_after(current, row[segments.SLOPE], curvature, rate, offset)
            shape_rate = row[segments.SHAPE_RATE]
            shape = row[segments.SHAPE] + shape_rate * offset
            c0 += shape * current
            c1 += shape_rate * current
            d0 += shape * slope
            d1 += shape_rate * slope
            q0 += shape * curvature
            q1 += shape_rate * curvature
        if until > time:
            low, high = _interval_extremes((c0, c1, d0, d1, q0, q1), rate, until - time, low, high)
        time = until
    return low * emf_constant, high * emf_constant


@inlined
def torque_range(
    drive: Any,
    phases: Any,
    positions: NDArray[np.int64],
    duration: float,
    lowest: float,
    highest: float,
) -> tuple[float, float]:
    """Widen a range by the torque of all phases over the last advance.

    Parameters
    ----------
    drive : named tuple
        The drive's constants, of any kind of drive; `emf_constant`, `resistance` and `inductance` are taken.
    phases : named tuple
        Holds the segments of that advance, in `rows` and `row_counts`; see `torque_extremes`.
    positions : ndarray of int64, shape (m,)
        Room for the computation.
    duration : float
        Length of the advance (s).
    lowest, highest : float
        Range so far (N m); start with inf and -inf.

    Returns
    -------
    lowest, highest : float
        Range including the advance (N m).
    """
    return torque_extremes(
        phases.rows,
        phases.row_counts,
        positions,
        drive.emf_constant,
        drive.resistance / drive.inductance,
        duration,
        lowest,
        highest,
    )
