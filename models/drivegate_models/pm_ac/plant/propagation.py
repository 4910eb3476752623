"""The currents between the segments of a control period: each segment is one affine map of the currents at its start.

The speed stands still in a period, so the coefficients of the maps' power series do too. The maps are independent of
each other and of the currents; what is left to do one after the other is a product and a sum.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.jets import Rates
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    COSINE,
    DIRECT,
    DIRECT_ADDED,
    DIRECT_BY_QUADRATURE,
    DIRECT_GROWTH,
    QUADRATURE,
    QUADRATURE_ADDED,
    QUADRATURE_BY_DIRECT,
    QUADRATURE_GROWTH,
    SINE,
    TIME,
    whole_groups,
)

SIX_ORDERS: Final = 0.0125
"""Longest segment over the time of the fastest rate (1) up to which the seventh term is below 1e-17; the ninth is up to
`two_points.SHORT`."""


class Order(NamedTuple):
    """What the currents gain in a time, over one power of it.

    With A the matrix of the equations, m half its trace and N = A - m, ``A**k / k!`` is ``even + odd N``.
    """

    even: float
    odd: float
    direct: float
    """Along the magnet's axis by the slope that the voltage gives along it."""
    direct_turning: float
    """Along it by that across."""
    quadrature_turning: float
    """Across it by that along."""
    quadrature: float
    """Across it by that across."""
    opposed: float
    """Along it by the voltage that the magnet induces."""
    opposed_across: float
    """Across it by that."""
    turned: float
    """What the voltages' turn back has left of them."""


@inlined
def _following(rates: Rates, half_trace: float, square: float, before: Order, order: int) -> Order:
    """Return an order from the one before; N times N is a square."""
    share = 1.0 / order
    by_across, by_along = rates.direct_turning, rates.quadrature_turning
    # Derivatives of an even order find the voltages where they were, those of an odd one a quarter turn back.
    is_even = order % 2 == 0
    straight = 0.0 if is_even else before.turned
    turning = before.turned if is_even else 0.0
    return Order(
        share * (half_trace * before.even + square * before.odd),
        share * (half_trace * before.odd + before.even),
        share * (rates.direct * before.direct + by_across * before.quadrature_turning + straight),
        share * (rates.direct * before.direct_turning + by_across * (before.quadrature + turning)),
        share * (rates.quadrature * before.quadrature_turning + by_along * (before.direct + turning)),
        share * (rates.quadrature * before.quadrature + by_along * before.direct_turning + straight),
        share * (rates.direct * before.opposed + by_across * before.opposed_across),
        share * (by_along * before.opposed + rates.quadrature * before.opposed_across),
        share * (before.turned * by_across * by_along if is_even else before.turned),
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
def _turned_by(begin: RotorFrame, angle: float) -> tuple[float, float]:
    """Return cosine and sine of the rotor's angle behind a small one (rad)."""
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
    """Write the map of each segment, and where the rotor is at its start."""
    half_trace = 0.5 * (rates.direct + rates.quadrature)
    difference = 0.5 * (rates.direct - rates.quadrature)
    square = difference * difference + rates.direct_turning * rates.quadrature_turning
    o1 = Order(half_trace, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, -rates.opposed, 1.0)
    o2 = _following(rates, half_trace, square, o1, 2)
    o3 = _following(rates, half_trace, square, o2, 3)
    o4 = _following(rates, half_trace, square, o3, 4)
    o5 = _following(rates, half_trace, square, o4, 5)
    o6 = _following(rates, half_trace, square, o5, 6)
    o7 = o6 if takes_six else _following(rates, half_trace, square, o6, 7)
    o8 = o6 if takes_six else _following(rates, half_trace, square, o7, 8)
    for n in range(whole_groups(count)):
        time = rows[TIME + n]
        length = rows[TIME + 1 + n] - time
        turned_cosine, turned_sine = _turned_by(begin, electrical * time)
        along, across = rows[ALONG + n], rows[ACROSS + n]
        driven = rates.per_direct * (turned_cosine * along + turned_sine * across)
        driven_across = rates.per_quadrature * (turned_cosine * across - turned_sine * along)
        even = _sum(takes_six, length, o1[0], o2[0], o3[0], o4[0], o5[0], o6[0], o7[0], o8[0])
        odd = _sum(takes_six, length, o1[1], o2[1], o3[1], o4[1], o5[1], o6[1], o7[1], o8[1])
        direct = _sum(takes_six, length, o1[2], o2[2], o3[2], o4[2], o5[2], o6[2], o7[2], o8[2])
        by_across = _sum(takes_six, length, o1[3], o2[3], o3[3], o4[3], o5[3], o6[3], o7[3], o8[3])
        by_along = _sum(takes_six, length, o1[4], o2[4], o3[4], o4[4], o5[4], o6[4], o7[4], o8[4])
        quadrature = _sum(takes_six, length, o1[5], o2[5], o3[5], o4[5], o5[5], o6[5], o7[5], o8[5])
        opposed = _sum(takes_six, length, o1[6], o2[6], o3[6], o4[6], o5[6], o6[6], o7[6], o8[6])
        opposed_across = _sum(takes_six, length, o1[7], o2[7], o3[7], o4[7], o5[7], o6[7], o7[7], o8[7])
        rows[COSINE + n] = turned_cosine
        rows[SINE + n] = turned_sine
        rows[DIRECT_GROWTH + n] = even + difference * odd
        rows[DIRECT_BY_QUADRATURE + n] = rates.direct_turning * odd
        rows[QUADRATURE_BY_DIRECT + n] = rates.quadrature_turning * odd
        rows[QUADRATURE_GROWTH + n] = even - difference * odd
        rows[DIRECT_ADDED + n] = direct * driven + by_across * driven_across + opposed
        rows[QUADRATURE_ADDED + n] = by_along * driven + quadrature * driven_across + opposed_across


@inlined
def propagate(
    rates: Rates,
    electrical: float,
    begin: RotorFrame,
    count: int,
    reach: float,
    rows: NDArray[np.float64],
) -> None:
    """Write the rotor's axes and the currents at the start of each segment, and behind the last one.

    Parameters
    ----------
    rates : Rates
        The equations.
    electrical : float
        Electrical speed (rad/s), by which the rotor turns no more than an eighth of a turn.
    begin : RotorFrame
        At the period's start.
    count : int
        Number of segments.
    reach : float
        Longest segment over the time of the fastest rate, at most `two_points.SHORT` (1).
    rows : ndarray
        Those of times and voltages are read; from `DIRECT` to `QUADRATURE_ADDED` they are written.
    """
    # Twice, so that each is compiled without what the other alone needs.
    if reach <= SIX_ORDERS:
        _write_maps(rates, electrical, begin, count, True, rows)
    else:
        _write_maps(rates, electrical, begin, count, False, rows)
    rows[COSINE + count], rows[SINE + count] = _turned_by(begin, electrical * rows[TIME + count])
    direct, quadrature = begin.direct, begin.quadrature
    rows[DIRECT] = direct
    rows[QUADRATURE] = quadrature
    for n in range(count):
        gained = (
            rows[DIRECT_GROWTH + n] * direct
            + rows[DIRECT_BY_QUADRATURE + n] * quadrature
            + rows[DIRECT_ADDED + n]
        )
        quadrature += (
            rows[QUADRATURE_BY_DIRECT + n] * direct
            + rows[QUADRATURE_GROWTH + n] * quadrature
            + rows[QUADRATURE_ADDED + n]
        )
        direct += gained
        rows[DIRECT + 1 + n] = direct
        rows[QUADRATURE + 1 + n] = quadrature
