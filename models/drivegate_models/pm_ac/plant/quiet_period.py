"""A control period in which no current comes near an event: all of its segments at once.

Every segment is an affine map of the currents, and every integral over it follows from the currents at its two ends, so
the arithmetic is the same for all and is done for several at a time. What a period needs to be quiet is looked at once.
"""

from __future__ import annotations

from math import inf
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, turned
from drivegate_models.pm_ac.plant.circuit import Circuit, sagitta
from drivegate_models.pm_ac.plant.jets import Currents, Rates, derivatives, standing
from drivegate_models.pm_ac.plant.modulator import Gates
from drivegate_models.pm_ac.plant.pattern import Upcoming, lay_out
from drivegate_models.pm_ac.plant.polynomial import extremes
from drivegate_models.pm_ac.plant.propagation import propagate
from drivegate_models.pm_ac.plant.quiet import curvature
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    CHARGE_ACROSS,
    CHARGE_ALONG,
    COSINE,
    DIRECT,
    DROP,
    LINK_ACROSS,
    LINK_ALONG,
    QUADRATURE,
    SINE,
    SQUARE,
    TIME,
    TORQUE,
    WIDTH,
    whole_groups,
)
from drivegate_models.pm_ac.plant.series import Series, free_series, phase_series
from drivegate_models.pm_ac.plant.settling import Legs
from drivegate_models.pm_ac.plant.two_points import SHORT, SHORTEST, sums_between

LONGEST_PERIOD: Final = 0.75
"""Longest period over the time of the fastest rate (1): the rotor turns by less than an eighth of a turn in it."""

_NOT_QUIET = -1.0


class PassedPeriod(NamedTuple):
    """What has become of a period."""

    segments: int
    """Into how many it was divided; 0 where something may happen in it, and nothing has been added."""
    frame: RotorFrame
    """At its end."""


@inlined
def _frame(rows: NDArray[np.float64], n: int) -> RotorFrame:
    """Return the currents and the rotor at an instant."""
    return RotorFrame(rows[DIRECT + n], rows[QUADRATURE + n], rows[COSINE + n], rows[SINE + n])


@inlined
def _derivatives(rates: Rates, rows: NDArray[np.float64], frame: RotorFrame, n: int) -> Currents:
    """Return the derivatives of the currents at an instant under the voltages of a segment."""
    along, across = rows[ALONG + n], rows[ACROSS + n]
    return derivatives(
        rates,
        frame.direct,
        frame.quadrature,
        rates.per_direct * (frame.cosine * along + frame.sine * across),
        rates.per_quadrature * (frame.cosine * across - frame.sine * along),
    )


@inlined
def _current(rows: NDArray[np.float64], n: int, leg: int) -> float:
    """Return the current of a phase at an instant (A)."""
    frame = _frame(rows, n)
    along, across = turned(frame, frame.direct, frame.quadrature)
    return of_phase(leg, along, across)


@inlined
def _slope(leg: int, frame: RotorFrame, slopes: Currents) -> float:
    """Return the slope of a phase current from those along standing axes (A/s)."""
    along, across = turned(frame, slopes.direct.slope, slopes.quadrature.slope)
    return of_phase(leg, along, across)


@inlined
def _is_monotone(circuit: Circuit, rates: Rates, rows: NDArray[np.float64], n: int, leg: int) -> bool:
    """Return whether a current only rises or only falls in a segment."""
    frame = _frame(rows, n)
    after = _frame(rows, n + 1)
    begin = standing(_derivatives(rates, rows, frame, n), circuit.electrical)
    end = standing(_derivatives(rates, rows, after, n), circuit.electrical)
    length = rows[TIME + 1 + n] - rows[TIME + n]
    change = 0.5 * length * curvature(circuit, begin, length)
    first = _slope(leg, frame, begin)
    last = _slope(leg, after, end)
    return bool(min(first, last) > change or max(first, last) < -change)


@unallocating
def _top_within(
    circuit: Circuit, series: Series, rows: NDArray[np.float64], n: int, leg: int, length: float
) -> float:
    """Return the greatest magnitude of a phase current in a segment (A), by its series."""
    frame = _frame(rows, n)
    along, across = rows[ALONG + n], rows[ACROSS + n]
    direct = frame.cosine * along + frame.sine * across
    quadrature = frame.cosine * across - frame.sine * along
    count = free_series(circuit, series, frame, direct, quadrature, length)
    phase_series(circuit, series, frame, leg, count, length)
    lowest, highest = extremes(series.other, count, series.slopes)
    return max(-lowest, highest)


@inlined
def _top(
    circuit: Circuit,
    rates: Rates,
    series: Series,
    rows: NDArray[np.float64],
    count: int,
    leg: int,
    most: float,
) -> float:
    """Return the greatest magnitude of a phase current (A), if that is above so much (A)."""
    top = most
    behind = abs(_current(rows, 0, leg))
    for n in range(count):
        before = behind
        behind = abs(_current(rows, n + 1, leg))
        if max(before, behind) > most:
            top = max(top, before, behind)
            if not _is_monotone(circuit, rates, rows, n, leg):
                top = max(
                    top, _top_within(circuit, series, rows, n, leg, rows[TIME + 1 + n] - rows[TIME + n])
                )
    return top


@inlined
def _keeps_sign(legs: Legs, leg: int, lowest: float, highest: float, deviation: float) -> bool:
    """Return whether a current that is within a range at all instants keeps the sign that its leg has."""
    if legs.sure[leg] != 0:
        return True
    return bool((lowest if legs.signs[leg] > 0 else -highest) > deviation)


@inlined
def _peak(
    circuit: Circuit,
    rates: Rates,
    legs: Legs,
    series: Series,
    rows: NDArray[np.float64],
    count: int,
    longest: float,
) -> float:
    """Return the greatest magnitude of any phase current (A), below 0 where one may come to zero."""
    lowest, lowest_second, lowest_third = inf, inf, inf
    highest, highest_second, highest_third = -inf, -inf, -inf
    for n in range(count + 1):
        frame = _frame(rows, n)
        along, across = turned(frame, frame.direct, frame.quadrature)
        second, third = of_phase(1, along, across), of_phase(2, along, across)
        lowest, highest = min(lowest, along), max(highest, along)
        lowest_second, highest_second = min(lowest_second, second), max(highest_second, second)
        lowest_third, highest_third = min(lowest_third, third), max(highest_third, third)
    deviation = sagitta(circuit, longest)
    if not (
        _keeps_sign(legs, 0, lowest, highest, deviation)
        and _keeps_sign(legs, 1, lowest_second, highest_second, deviation)
        and _keeps_sign(legs, 2, lowest_third, highest_third, deviation)
    ):
        return _NOT_QUIET
    tops = (
        max(highest, -lowest),
        max(highest_second, -lowest_second),
        max(highest_third, -lowest_third),
    )
    peak = max(tops[0], tops[1], tops[2])
    most = peak - deviation
    for leg in range(3):
        if tops[leg] > most:
            peak = max(peak, _top(circuit, rates, series, rows, count, leg, most))
    return peak


@inlined
def _integrate(
    circuit: Circuit, rates: Rates, count: int, is_shortest: bool, rows: NDArray[np.float64]
) -> None:
    """Write the integrals over each segment."""
    for n in range(whole_groups(count)):
        frame = _frame(rows, n)
        after = _frame(rows, n + 1)
        begin = _derivatives(rates, rows, frame, n)
        end = _derivatives(rates, rows, after, n)
        length = rows[TIME + 1 + n] - rows[TIME + n]
        sums = sums_between(circuit, begin, end, frame, after, length, is_shortest)
        rows[SQUARE + n] = sums.square
        rows[TORQUE + n] = sums.torque
        rows[CHARGE_ALONG + n] = sums.along
        rows[CHARGE_ACROSS + n] = sums.across


@inlined
def _add_drops(circuit: Circuit, rows: NDArray[np.float64], count: int, totals: NDArray[np.float64]) -> None:
    """Add the loss in the forward drops to the ledger."""
    if circuit.switch_drop == 0.0 and circuit.diode_drop == 0.0:
        return
    lost = 0.0
    for n in range(count):
        for leg in range(3):
            charge = of_phase(leg, rows[CHARGE_ALONG + n], rows[CHARGE_ACROSS + n])
            lost += rows[DROP + leg * WIDTH + n] * abs(charge)
    totals[ledger.DEVICE] += lost


@inlined
def _add(
    pole_pairs: float,
    circuit: Circuit,
    rows: NDArray[np.float64],
    count: int,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add all segments to the ledger."""
    square, torque, along, across, taken, exchanged = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        square += rows[SQUARE + n]
        torque += rows[TORQUE + n]
        along += rows[CHARGE_ALONG + n]
        across += rows[CHARGE_ACROSS + n]
        charge = (
            rows[LINK_ALONG + n] * rows[CHARGE_ALONG + n] + rows[LINK_ACROSS + n] * rows[CHARGE_ACROSS + n]
        )
        taken += charge
        exchanged += abs(charge)
    totals[ledger.SQUARE] += 1.5 * square
    totals[ledger.IMPULSE] += 1.5 * pole_pairs * torque
    totals[ledger.UPPER] += 0.5 * circuit.link * taken
    totals[ledger.LOWER] += 0.5 * circuit.link * taken
    totals[ledger.EXCHANGED] += circuit.link * exchanged
    totals[ledger.RETURNED] += 0.5 * circuit.link * (exchanged - taken)
    for leg in range(3):
        magnitude = abs(of_phase(leg, along, across))
        magnitudes[leg] += magnitude
        totals[ledger.MAGNITUDE] += magnitude
    _add_drops(circuit, rows, count, totals)


@inlined
def pass_period(
    pole_pairs: float,
    circuit: Circuit,
    rates: Rates,
    legs: Legs,
    gates: Gates,
    upcoming: Upcoming,
    frame: RotorFrame,
    duration: float,
    series: Series,
    rows: NDArray[np.float64],
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> PassedPeriod:
    """Pass a whole period at whose start no leg is held and add it to the ledger, if nothing can happen in it.

    Parameters
    ----------
    pole_pairs : float
        Of the machine (1).
    circuit : Circuit
        Constants of the advance.
    rates : Rates
        Its equations.
    legs : Legs
        Signs at the start.
    gates : Gates
        Schedule, of which nothing has been passed.
    upcoming : Upcoming
        Room.
    frame : RotorFrame
        At the period's start.
    duration : float
        Its length, at most `LONGEST_PERIOD` over the circuit's rate (s).
    series : Series
        Room.
    rows : ndarray
        Room, as `rows` has it.
    magnitudes : ndarray, shape (3,)
        Integral of each phase's current magnitude (A s), added to.
    totals : ndarray, shape (ledger.ENTRIES,)
        Exact integrals, added to, but for what the switches lose.

    Returns
    -------
    PassedPeriod
        No segments where a current may come to zero, or where a segment is too long or there are too many.
    """
    pattern = lay_out(circuit, legs, gates, upcoming, duration, rows)
    count = pattern.segments
    reach = circuit.rate * pattern.longest
    if count == 0 or reach > SHORT:
        return PassedPeriod(0, frame)
    propagate(rates, circuit.electrical, frame, count, reach, rows)
    peak = _peak(circuit, rates, legs, series, rows, count, pattern.longest)
    if peak < 0.0:
        return PassedPeriod(0, frame)
    totals[ledger.PEAK] = max(totals[ledger.PEAK], peak)
    # Twice, so that each is compiled without what the other alone needs.
    if reach <= SHORTEST:
        _integrate(circuit, rates, count, True, rows)
    else:
        _integrate(circuit, rates, count, False, rows)
    _add(pole_pairs, circuit, rows, count, magnitudes, totals)
    return PassedPeriod(count, _frame(rows, count))
