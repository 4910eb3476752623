"""Integrals over many segments of a period of a link with a capacitor, from their series, for both ledgers."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.dc_link import CHOPPER, LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.integrals import PLACES, WEIGHTS, add_exchange
from drivegate_models.pm_ac.plant.linked_series import Feed
from drivegate_models.pm_ac.plant.polynomial import extremes
from drivegate_models.pm_ac.plant.quiet_period import add_drops, add_magnitude
from drivegate_models.pm_ac.plant.rows import (
    CHARGE_ACROSS,
    CHARGE_ALONG,
    COSINE,
    DEVIATION,
    DROPPED,
    DROPPED_SQUARE,
    ENERGY,
    LINK_ACROSS,
    LINK_ALONG,
    PHASE_ENDS,
    SERIES_ACROSS,
    SERIES_ALONG,
    SERIES_ORDERS,
    SERIES_VOLTAGE,
    SINE,
    SQUARE,
    TIME,
    TORQUE,
    WIDTH,
    whole_groups,
)
from drivegate_models.pm_ac.plant.series import Series

FEW_ORDERS: Final = 9
"""Coefficients of the series that most segments need."""
# First place of the rule with five points.
_FIVE: Final = 7


class Means(NamedTuple):
    """Products at one place of a segment, times a weight."""

    square: float
    torque: float
    along: float
    across: float
    dropped: float
    dropped_square: float
    power: float


@inlined
def _at(rows: NDArray[np.float64], row: int, place: float, has_few: bool) -> float:
    """Return the value of a series at a place of its segment, whose first coefficient is at `row`.

    `has_few`: true if all coefficients from `FEW_ORDERS` on are zero.
    """
    value = rows[row + 8 * WIDTH]
    if not has_few:
        last = rows[row + 10 * WIDTH] + place * rows[row + 11 * WIDTH]
        value += place * (rows[row + 9 * WIDTH] + place * last)
    value = rows[row + 6 * WIDTH] + place * (rows[row + 7 * WIDTH] + place * value)
    value = rows[row + 4 * WIDTH] + place * (rows[row + 5 * WIDTH] + place * value)
    value = rows[row + 2 * WIDTH] + place * (rows[row + 3 * WIDTH] + place * value)
    return float(rows[row] + place * (rows[row + WIDTH] + place * value))


@inlined
def _means(
    circuit: Circuit,
    source: float,
    rows: NDArray[np.float64],
    n: int,
    angle: float,
    place: float,
    weight: float,
    has_few: bool,
) -> Means:
    """Return the products at a place of a segment, of which the rotor turns by an angle (rad)."""
    along, across = _at(rows, SERIES_ALONG + n, place, has_few), _at(rows, SERIES_ACROSS + n, place, has_few)
    voltage = _at(rows, SERIES_VOLTAGE + n, place, has_few)
    by_cosine, by_sine = small_cosine_sine(angle * place)
    cosine = rows[COSINE + n] * by_cosine - rows[SINE + n] * by_sine
    sine = rows[SINE + n] * by_cosine + rows[COSINE + n] * by_sine
    direct = cosine * along + sine * across
    quadrature = cosine * across - sine * along
    dropped = source - voltage
    bridge = rows[LINK_ALONG + n] * along + rows[LINK_ACROSS + n] * across
    saliency = circuit.direct - circuit.quadrature
    return Means(
        weight * (along * along + across * across),
        weight * (circuit.flux * quadrature + saliency * (direct * quadrature)),
        weight * along,
        weight * across,
        weight * dropped,
        weight * (dropped * dropped),
        weight * (voltage * bridge),
    )


@inlined
def integrate_linked(
    circuit: Circuit, source: float, count: int, has_few: bool, rows: NDArray[np.float64]
) -> None:
    """Write the integrals over each segment; `has_few`: as in `_at`."""
    for n in range(whole_groups(count)):
        length = rows[TIME + 1 + n] - rows[TIME + n]
        angle = circuit.electrical * length
        p0 = _means(circuit, source, rows, n, angle, PLACES[_FIVE], WEIGHTS[_FIVE], has_few)
        p1 = _means(circuit, source, rows, n, angle, PLACES[_FIVE + 1], WEIGHTS[_FIVE + 1], has_few)
        p2 = _means(circuit, source, rows, n, angle, PLACES[_FIVE + 2], WEIGHTS[_FIVE + 2], has_few)
        p3 = _means(circuit, source, rows, n, angle, PLACES[_FIVE + 3], WEIGHTS[_FIVE + 3], has_few)
        p4 = _means(circuit, source, rows, n, angle, PLACES[_FIVE + 4], WEIGHTS[_FIVE + 4], has_few)
        rows[SQUARE + n] = length * (p0.square + p1.square + p2.square + p3.square + p4.square)
        rows[TORQUE + n] = length * (p0.torque + p1.torque + p2.torque + p3.torque + p4.torque)
        rows[CHARGE_ALONG + n] = length * (p0.along + p1.along + p2.along + p3.along + p4.along)
        rows[CHARGE_ACROSS + n] = length * (p0.across + p1.across + p2.across + p3.across + p4.across)
        rows[DROPPED + n] = length * (p0.dropped + p1.dropped + p2.dropped + p3.dropped + p4.dropped)
        rows[DROPPED_SQUARE + n] = length * (
            p0.dropped_square + p1.dropped_square + p2.dropped_square + p3.dropped_square + p4.dropped_square
        )
        rows[ENERGY + n] = length * (p0.power + p1.power + p2.power + p3.power + p4.power)


@inlined
def peak_of_series(series: Series, rows: NDArray[np.float64], count: int) -> float:
    """Return the maximum magnitude of any phase current (A)."""
    peak = 0.0
    for leg in range(3):
        for n in range(count + 1):
            peak = max(peak, abs(rows[PHASE_ENDS + leg * WIDTH + n]))
    for leg in range(3):
        for n in range(count):
            begin, end = rows[PHASE_ENDS + leg * WIDTH + n], rows[PHASE_ENDS + leg * WIDTH + n + 1]
            deviation = rows[DEVIATION + n]
            if max(abs(begin), abs(end)) + deviation > peak and abs(end - begin) <= 8.0 * deviation:
                for k in range(SERIES_ORDERS):
                    series.other[k] = of_phase(
                        leg, rows[SERIES_ALONG + k * WIDTH + n], rows[SERIES_ACROSS + k * WIDTH + n]
                    )
                lowest, highest = extremes(series.other, SERIES_ORDERS, series.slopes)
                peak = max(peak, -lowest, highest)
    return peak


@inlined
def add_link(
    drive: PmAcDrive, feed: Feed, link: LinkState, duration: float, count: int, rows: NDArray[np.float64]
) -> None:
    """Add all segments to the link's ledger."""
    totals, constants = link.totals, drive.dc_link
    dropped = dropped_square = drawn = bridge = energy = exchanged = 0.0
    for n in range(count):
        dropped += rows[DROPPED + n]
        dropped_square += rows[DROPPED_SQUARE + n]
        drawn += abs(rows[DROPPED + n])
        bridge += (
            rows[LINK_ALONG + n] * rows[CHARGE_ALONG + n] + rows[LINK_ACROSS + n] * rows[CHARGE_ACROSS + n]
        )
        energy += rows[ENERGY + n]
        exchanged += abs(rows[ENERGY + n])
    flux = feed.source * duration - dropped
    square = feed.source * (feed.source * duration - 2.0 * dropped) + dropped_square
    charge = feed.per_resistance * dropped
    resisted = constants.source_resistance * feed.per_resistance * feed.per_resistance * dropped_square
    chopper = constants.chopper_conductance if link.state[CHOPPER] != 0.0 else 0.0
    lost = feed.conductance - chopper
    totals[dc_link.DRAWN] += feed.source * charge
    totals[dc_link.RESISTED] += resisted
    totals[dc_link.BURNT] += chopper * square
    totals[dc_link.SUPPLIED] += lost * square
    totals[dc_link.SOURCE_CHARGE] += charge
    totals[dc_link.BRIDGE_CHARGE] += bridge + lost * flux
    totals[dc_link.FLUX] += flux
    totals[dc_link.BRIDGE] += energy
    totals[dc_link.THROUGHPUT] += (
        feed.source * feed.per_resistance * drawn + resisted + feed.conductance * square + exchanged
    )


@inlined
def add_machine(
    drive: PmAcDrive,
    circuit: Circuit,
    rows: NDArray[np.float64],
    count: int,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add all segments, in which no current changes its sign, to the machine's ledger."""
    square = torque = along = across = 0.0
    for n in range(count):
        square += rows[SQUARE + n]
        torque += rows[TORQUE + n]
        along += rows[CHARGE_ALONG + n]
        across += rows[CHARGE_ACROSS + n]
        add_exchange(rows[ENERGY + n], abs(rows[ENERGY + n]), totals)
    totals[ledger.SQUARE] += 1.5 * square
    totals[ledger.IMPULSE] += 1.5 * drive.pole_pairs * torque
    for leg in range(3):
        add_magnitude(leg, abs(of_phase(leg, along, across)), magnitudes, totals)
    add_drops(circuit, rows, count, totals)
