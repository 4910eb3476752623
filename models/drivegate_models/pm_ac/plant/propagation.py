"""The currents at the ends of a period's segments: each segment is an affine map of the currents at its start.

The speed is constant in a period, so the natural response has the same power series in all segments. The forced
response has a separate series in each. The maps are independent of each other and of the currents; only a product
and a sum remain to be computed sequentially.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, turned
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.jets import Rates, Step, following_step
from drivegate_models.pm_ac.plant.phase_segments import frame_at
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    COSINE,
    DIRECT,
    DIRECT_ADDED,
    DIRECT_BY_QUADRATURE,
    DIRECT_GROWTH,
    PHASE,
    QUADRATURE,
    QUADRATURE_ADDED,
    QUADRATURE_BY_DIRECT,
    QUADRATURE_GROWTH,
    SINE,
    TIME,
    WIDTH,
    whole_groups,
)

SIX_ORDERS: Final = 0.0125
"""Maximum segment times the fastest rate (1) for which the seventh term is below 1e-17. The ninth term is below it
up to `two_points.SHORT`."""


class Order(NamedTuple):
    """Coefficients of one power of time in the natural response of the currents.

    With A the matrix of the equations, m half its trace and N = A - m, ``A**k / k!`` is ``even + odd N``.
    """

    even: float
    odd: float


@inlined
def _following_order(half_trace: float, square: float, before: Order, order: int) -> Order:
    """Return an order of the natural response from the preceding one; N times N is the scalar `square`."""
    share = 1.0 / order
    return Order(
        share * (half_trace * before.even + square * before.odd),
        share * (half_trace * before.odd + before.even),
    )


@inlined
def _sum(
    takes_six: bool,
    length: float,
    first: float,
    second: float,
    third: float,
    fourth: float,
    fifth: float,
    sixth: float,
    seventh: float,
    eighth: float,
) -> float:
    """Return the sum of a power series without its value at zero."""
    tail = sixth
    if not takes_six:
        tail += length * (seventh + length * eighth)
    return length * (
        first + length * (second + length * (third + length * (fourth + length * (fifth + length * tail))))
    )


@inlined
def _added(
    rates: Rates, length: float, driven: float, driven_across: float, takes_six: bool
) -> tuple[float, float]:
    """Return the currents after a segment from zero (A), from the slopes by its voltages alone (A/s)."""
    driven *= length
    driven_across *= length
    x1 = Step(driven, driven_across - length * rates.opposed, driven, driven_across)
    x2 = following_step(rates, length, x1, 2)
    x3 = following_step(rates, length, x2, 3)
    x4 = following_step(rates, length, x3, 4)
    x5 = following_step(rates, length, x4, 5)
    x6 = following_step(rates, length, x5, 6)
    direct, quadrature = x6.direct, x6.quadrature
    if not takes_six:
        x7 = following_step(rates, length, x6, 7)
        x8 = following_step(rates, length, x7, 8)
        direct += x7.direct + x8.direct
        quadrature += x7.quadrature + x8.quadrature
    return (
        x1.direct + (x2.direct + (x3.direct + (x4.direct + (x5.direct + direct)))),
        x1.quadrature + (x2.quadrature + (x3.quadrature + (x4.quadrature + (x5.quadrature + quadrature)))),
    )


@inlined
def _turned_by(begin: RotorFrame, angle: float) -> tuple[float, float]:
    """Return cosine and sine of the rotor's angle after a small rotation (rad)."""
    cosine, sine = small_cosine_sine(angle)
    return begin.cosine * cosine - begin.sine * sine, begin.sine * cosine + begin.cosine * sine


@inlined
def _write_maps(
    rates: Rates,
    electrical: float,
    begin: RotorFrame,
    count: int,
    takes_six: bool,
    rows: NDArray[np.float64],
) -> None:
    """Write the map of each segment, and the rotor's angle at its start."""
    half_trace = 0.5 * (rates.direct + rates.quadrature)
    difference = 0.5 * (rates.direct - rates.quadrature)
    square = difference * difference + rates.direct_turning * rates.quadrature_turning
    o1 = Order(half_trace, 1.0)
    o2 = _following_order(half_trace, square, o1, 2)
    o3 = _following_order(half_trace, square, o2, 3)
    o4 = _following_order(half_trace, square, o3, 4)
    o5 = _following_order(half_trace, square, o4, 5)
    o6 = _following_order(half_trace, square, o5, 6)
    o7 = o6 if takes_six else _following_order(half_trace, square, o6, 7)
    o8 = o6 if takes_six else _following_order(half_trace, square, o7, 8)
    for n in range(whole_groups(count)):
        time = rows[TIME + n]
        length = rows[TIME + 1 + n] - time
        turned_cosine, turned_sine = _turned_by(begin, electrical * time)
        along, across = rows[ALONG + n], rows[ACROSS + n]
        driven = rates.per_direct * (turned_cosine * along + turned_sine * across)
        driven_across = rates.per_quadrature * (turned_cosine * across - turned_sine * along)
        even = _sum(takes_six, length, o1[0], o2[0], o3[0], o4[0], o5[0], o6[0], o7[0], o8[0])
        odd = _sum(takes_six, length, o1[1], o2[1], o3[1], o4[1], o5[1], o6[1], o7[1], o8[1])
        added, added_across = _added(rates, length, driven, driven_across, takes_six)
        rows[COSINE + n] = turned_cosine
        rows[SINE + n] = turned_sine
        rows[DIRECT_GROWTH + n] = even + difference * odd
        rows[DIRECT_BY_QUADRATURE + n] = rates.direct_turning * odd
        rows[QUADRATURE_BY_DIRECT + n] = rates.quadrature_turning * odd
        rows[QUADRATURE_GROWTH + n] = even - difference * odd
        rows[DIRECT_ADDED + n] = added
        rows[QUADRATURE_ADDED + n] = added_across


@inlined
def _write_phases(rows: NDArray[np.float64], n: int) -> None:
    """Write the phase currents at an instant."""
    frame = frame_at(rows, n)
    along, across = turned(frame, frame.direct, frame.quadrature)
    rows[PHASE + n] = along
    rows[PHASE + WIDTH + n] = of_phase(1, along, across)
    rows[PHASE + 2 * WIDTH + n] = of_phase(2, along, across)


@inlined
def propagate(
    rates: Rates,
    electrical: float,
    begin: RotorFrame,
    count: int,
    reach: float,
    rows: NDArray[np.float64],
) -> None:
    """Write the rotor's angle and all currents at the start of each segment, and after the last one.

    `electrical`: electrical speed (rad/s); the rotor turns by at most an eighth of a turn in the period. `count`:
    number of segments. `reach`: longest segment times the fastest rate, at most `two_points.SHORT` (1). `rows`: the
    rows of times and voltages are read; the rows from `PHASE` to `QUADRATURE_ADDED` are written.
    """
    # Two calls, so that each is compiled without the code that only the other needs.
    if reach <= SIX_ORDERS:
        _write_maps(rates, electrical, begin, count, True, rows)
    else:
        _write_maps(rates, electrical, begin, count, False, rows)
    rows[COSINE + count], rows[SINE + count] = _turned_by(begin, electrical * rows[TIME + count])
    direct, quadrature = begin.direct, begin.quadrature
    rows[DIRECT] = direct
    rows[QUADRATURE] = quadrature
    for n in range(count):
        # Add the result of the preceding segment that is available last in the last operation.
        gained = rows[DIRECT_GROWTH + n] * direct + (
            rows[DIRECT_BY_QUADRATURE + n] * quadrature + rows[DIRECT_ADDED + n]
        )
        quadrature += rows[QUADRATURE_GROWTH + n] * quadrature + (
            rows[QUADRATURE_BY_DIRECT + n] * direct + rows[QUADRATURE_ADDED + n]
        )
        direct += gained
        rows[DIRECT + 1 + n] = direct
        rows[QUADRATURE + 1 + n] = quadrature
    for n in range(whole_groups(count)):
        _write_phases(rows, n)
    _write_phases(rows, count)
