"""A control period in which no current is near an event that changes a voltage: all segments at once.

Every segment is an affine map of the currents, and every integral over it is computed from the currents at its two
ends. The arithmetic is therefore the same for all segments and is vectorized. The conditions for a quiet period are
checked once.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase
from drivegate_models.pm_ac.plant.circuit import Circuit, has_drops
from drivegate_models.pm_ac.plant.crossings import Returning, ignores_sign, passes_zero, returning_of
from drivegate_models.pm_ac.plant.jets import Rates
from drivegate_models.pm_ac.plant.modulator import Gates
from drivegate_models.pm_ac.plant.pattern import Upcoming, lay_out
from drivegate_models.pm_ac.plant.peaks import keeps_sign, peak_of, ranges_of
from drivegate_models.pm_ac.plant.phase_segments import derivatives_at, frame_at
from drivegate_models.pm_ac.plant.propagation import propagate
from drivegate_models.pm_ac.plant.rows import (
    CHARGE_ACROSS,
    CHARGE_ALONG,
    DROP,
    LINK_ACROSS,
    LINK_ALONG,
    SQUARE,
    TIME,
    TORQUE,
    WIDTH,
    whole_groups,
)
from drivegate_models.pm_ac.plant.series import Series
from drivegate_models.pm_ac.plant.settling import Legs
from drivegate_models.pm_ac.plant.two_points import SHORT, SHORTEST, sums_between

LONGEST_PERIOD: Final = 0.75
"""Maximum period times the fastest rate (1): the rotor turns by less than an eighth of a turn in it."""

_NONE: Final = Returning(0.0, 0.0)


class PassedPeriod(NamedTuple):
    """Result for a period."""

    segments: int
    """Number of its segments; 0 if an event is possible in it, and nothing has been added."""
    frame: RotorFrame
    """Currents and angle at its end."""


@inlined
def _integrate(
    circuit: Circuit, rates: Rates, count: int, is_shortest: bool, rows: NDArray[np.float64]
) -> None:
    """Write the integrals over each segment."""
    for n in range(whole_groups(count)):
        frame = frame_at(rows, n)
        after = frame_at(rows, n + 1)
        begin = derivatives_at(rates, rows, frame, n)
        end = derivatives_at(rates, rows, after, n)
        length = rows[TIME + 1 + n] - rows[TIME + n]
        sums = sums_between(circuit, begin, end, frame, after, length, is_shortest)
        rows[SQUARE + n] = sums.square
        rows[TORQUE + n] = sums.torque
        rows[CHARGE_ALONG + n] = sums.along
        rows[CHARGE_ACROSS + n] = sums.across


@inlined
def add_drops(circuit: Circuit, rows: NDArray[np.float64], count: int, totals: NDArray[np.float64]) -> None:
    """Add the loss in the forward drops to the ledger."""
    if not has_drops(circuit):
        return
    lost = 0.0
    for n in range(count):
        for leg in range(3):
            charge = of_phase(leg, rows[CHARGE_ALONG + n], rows[CHARGE_ACROSS + n])
            lost += rows[DROP + leg * WIDTH + n] * abs(charge)
    totals[ledger.DEVICE] += lost


@inlined
def add_magnitude(
    leg: int, magnitude: float, magnitudes: NDArray[np.float64], totals: NDArray[np.float64]
) -> None:
    """Add the integral of a current's magnitude to the ledger (A s)."""
    magnitudes[leg] += magnitude
    totals[ledger.MAGNITUDE] += magnitude


@inlined
def _add(
    pole_pairs: float,
    circuit: Circuit,
    rows: NDArray[np.float64],
    count: int,
    returning: tuple[Returning, Returning, Returning],
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add all segments to the ledger."""
    square, torque, along, across, drawn, exchanged = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        square += rows[SQUARE + n]
        torque += rows[TORQUE + n]
        along += rows[CHARGE_ALONG + n]
        across += rows[CHARGE_ACROSS + n]
        charge = (
            rows[LINK_ALONG + n] * rows[CHARGE_ALONG + n] + rows[LINK_ACROSS + n] * rows[CHARGE_ACROSS + n]
        )
        drawn += charge
        exchanged += abs(charge)
    first, second, third = returning
    exchanged += first.exchanged + second.exchanged + third.exchanged
    totals[ledger.SQUARE] += 1.5 * square
    totals[ledger.IMPULSE] += 1.5 * pole_pairs * torque
    totals[ledger.UPPER] += 0.5 * circuit.link * drawn
    totals[ledger.LOWER] += 0.5 * circuit.link * drawn
    totals[ledger.EXCHANGED] += circuit.link * exchanged
    totals[ledger.RETURNED] += 0.5 * circuit.link * (exchanged - drawn)
    add_magnitude(0, abs(along) + first.magnitude, magnitudes, totals)
    add_magnitude(1, abs(of_phase(1, along, across)) + second.magnitude, magnitudes, totals)
    add_magnitude(2, abs(of_phase(2, along, across)) + third.magnitude, magnitudes, totals)
    add_drops(circuit, rows, count, totals)


@inlined
def _may_change(
    circuit: Circuit, rates: Rates, gates: Gates, rows: NDArray[np.float64], count: int, leg: int
) -> bool:
    """Return True if a period can be computed at once although a current may change its sign."""
    return ignores_sign(circuit, gates, leg) and passes_zero(circuit, rates, rows, count, leg)


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
    """Pass a whole period without a held leg at its start, and add it to the ledger if no event is possible in it.

    - `pole_pairs`: pole pairs of the machine (1).
    - `duration`: length of the period, at most `LONGEST_PERIOD` over the circuit's rate (s).
    - `rows`: work space, as in `rows`.
    - `magnitudes`, shape (3,): the integrals of the current magnitudes (A s) are added to it.
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it, except for the loss of the switches.
    - Result: no segments if a current may reach zero with an effect on a voltage, if a segment is too long, or if
      there are too many segments.
    """
    pattern = lay_out(circuit, legs, gates, upcoming, 0.0, duration, rows)
    count = pattern.segments
    reach = circuit.rate * pattern.longest
    if count == 0 or reach > SHORT:
        return PassedPeriod(0, frame)
    propagate(rates, circuit.electrical, frame, count, reach, rows)
    ranges = ranges_of(circuit, rows, count, pattern.longest)
    deviation = ranges.deviation
    keeps_first = keeps_sign(legs, 0, ranges.first, deviation)
    keeps_second = keeps_sign(legs, 1, ranges.second, deviation)
    keeps_third = keeps_sign(legs, 2, ranges.third, deviation)
    if not (
        (keeps_first or _may_change(circuit, rates, gates, rows, count, 0))
        and (keeps_second or _may_change(circuit, rates, gates, rows, count, 1))
        and (keeps_third or _may_change(circuit, rates, gates, rows, count, 2))
    ):
        return PassedPeriod(0, frame)
    # Two calls, so that each is compiled without the code that only the other needs.
    if reach <= SHORTEST:
        _integrate(circuit, rates, count, True, rows)
    else:
        _integrate(circuit, rates, count, False, rows)
    returning = (
        _NONE if keeps_first else returning_of(circuit, rates, rows, count, 0),
        _NONE if keeps_second else returning_of(circuit, rates, rows, count, 1),
        _NONE if keeps_third else returning_of(circuit, rates, rows, count, 2),
    )
    totals[ledger.PEAK] = max(totals[ledger.PEAK], peak_of(circuit, rates, ranges, series, rows, count))
    _add(pole_pairs, circuit, rows, count, returning, magnitudes, totals)
    return PassedPeriod(count, frame_at(rows, count))
