"""Exact extremes of the torque over an advance, from the segments of all phases.

Between events the torque is a polynomial of second degree plus a straight line times one exponential. Its third
derivative therefore has at most one zero. Nested isolation from this zero finds every stationary point.
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
    """Return torque over EMF constant (A) and its first two time derivatives, at a time within the interval (s)."""
    c0, c1, d0, d1, q0, q1 = coefficients
    # From phi4 downward, as in `winding_current`: upward recurrence suffers cancellation at small R t / L.
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
    # Because of the chord bound below few intervals get here, so plain halving is fast enough.
    for _ in range(100):
        middle = 0.5 * (low + high)
        # There is no float in between.
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
    """Extend [lowest, highest] by the torque over EMF constant on one interval without events (A)."""
    start, start_first, start_second = _derivatives(coefficients, rate, 0.0)
    end, end_first, end_second = _derivatives(coefficients, rate, length)
    lowest = min(lowest, start, end)
    highest = max(highest, start, end)
    _, _, d0, d1, q0, q1 = coefficients
    # The only zero of the third derivative. Without resistance that derivative is constant and has no zero.
    divisor = rate * (rate * d1 + q1)
    inflection = 0.0
    if divisor != 0.0:
        inflection = (3.0 * (rate * d1 + q1) - rate * (rate * d0 + q0)) / divisor
    bends = 0.0 < inflection < length
    # In this case the second derivative does not change its sign, so the first is monotone and does not either.
    if not bends and start_second * end_second > 0.0 and start_first * end_first > 0.0:
        return lowest, highest
    # A function deviates from its chord by at most an eighth of its maximum second derivative times the length squared.
    steepest = max(abs(start_second), abs(end_second))
    if bends:
        steepest = max(steepest, abs(_derivatives(coefficients, rate, inflection)[2]))
    off_chord = 0.125 * steepest * length * length
    # Skip an interval that cannot leave the known range: this saves most intervals of a cycle.
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
    """Extend a range by the torque of all phases over one advance.

    - `rows`, shape (m, n, segments.FIELDS): segments of each phase, without gaps from 0 to `duration`.
    - `row_counts`, shape (m,): number of segments of each phase.
    - `positions`, shape (m,): work space.
    - `emf_constant`: peak torque per ampere (N m/A).
    - `rate`: R/L (1/s).
    - `duration`: length of the advance (s).
    - `lowest`, `highest`: range so far (N m); start with inf and -inf.
    - Returns `lowest`, `highest`: range including this advance (N m), from events and stationary points, not from a
      grid.
    """
    phases = rows.shape[0]
    positions[:] = 0
    # Divide by the common factor once, instead of multiplying every evaluation by it.
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
            # Never pass the last segment: by rounding it may end before the advance.
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
            # With every phase at the same instant, the sum has six coefficients in total.
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
    """Extend a range by the torque of all phases over the last advance.

    `drive`: constants of any kind of drive with `emf_constant`, `resistance` and `inductance`. `phases`: with the
    segments of that advance, in `rows` and `row_counts`. The other arguments and the results are those of
    `torque_extremes`.
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
