"""Integrals of one segment for both ledgers of a drive whose link has a capacitor: the machine's and the link's."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, phase_current, turned
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.circuit import Circuit, is_on_upper_rail, sagitta
from drivegate_models.pm_ac.plant.dc_link import CHOPPER, DcLink, LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.integrals import (
    PLACES,
    WEIGHTS,
    add_exchange,
    add_magnitude,
    extend_torque_range,
    magnitude_and_peak,
    magnitude_of,
    supply_leg,
)
from drivegate_models.pm_ac.plant.linked_events import voltage_range
from drivegate_models.pm_ac.plant.linked_series import Feed, turn_into_rotor_frame
from drivegate_models.pm_ac.plant.polynomial import extremes, integral_to, value_at
from drivegate_models.pm_ac.plant.series import LONGEST, TERMS, Series, standing_phase_series
from drivegate_models.pm_ac.plant.settling import EMPTY, FREE, Legs

# The rules with 3, 4, 5 and 6 points. For a product of two quantities that grow with the rate r of a segment the error
# of n points is n!**4 / ((2n + 1) (2n)!**3) (2 r)**(2n): 8e-13 with 6 points and r = 1, the greatest that is used.
_ALL_PLACES: Final = (
    *PLACES,
    0.03376524289842399,
    0.16939530676686773,
    0.38069040695840156,
    0.6193095930415985,
    0.8306046932331322,
    0.966234757101576,
)
_ALL_WEIGHTS: Final = (
    *WEIGHTS,
    0.08566224618958518,
    0.1803807865240693,
    0.23395696728634552,
    0.23395696728634552,
    0.1803807865240693,
    0.08566224618958518,
)
_SIX_POINTS: Final = 12
# Segment times the fastest rate up to which three and four points have a relative error below 1e-11 for the square of a
# current that begins at zero: 9e-5 r**4 and 4e-7 r**6.
_THREE_POINTS: Final = 0.018
_FOUR_POINTS: Final = 0.16
_NEWTON_STEPS: Final = 4
# Excess of the integral of a current's magnitude over the magnitude of its integral that is only rounding.
_ROUNDING = 1e-12


@inlined
def _rule(reach: float, is_free: bool) -> tuple[int, int]:
    """Return the first place and the number of places for a segment times the fastest rate (1)."""
    if is_free and reach <= _THREE_POINTS:
        return 0, 3
    if is_free and reach <= _FOUR_POINTS:
        return 3, 4
    if reach <= LONGEST:
        return 7, 5
    return _SIX_POINTS, 6


class LegShare(NamedTuple):
    """What a segment adds for one leg."""

    magnitude: float
    """Integral of the current's magnitude (A s)."""
    peak: float
    """Maximum magnitude of a current so far (A)."""
    zero: float
    """Share of the segment at which a monotone current crosses zero, 0 without one (1)."""


@inlined
def _zero_of_monotone(series: Series, count: int, begin: float, end: float) -> float:
    """Return the share of a segment at which the monotone current in `other` crosses zero.

    Newton's method from the chord's zero, of which the current deviates by at most an eighth of its change. An error
    of the zero counts in an integral of the magnitude by its square.
    """
    share = begin / (begin - end)
    for _ in range(_NEWTON_STEPS):
        value = slope = 0.0
        for k in range(count - 1, -1, -1):
            slope = slope * share + value
            value = value * share + series.other[k]
        share = min(max(share - value / slope, 0.0), 1.0)
    return share


@inlined
def _leg_share(
    circuit: Circuit,
    series: Series,
    frame: RotorFrame,
    after: RotorFrame,
    leg: int,
    charge: float,
    count: int,
    length: float,
    is_smooth: bool,
    peak: float,
) -> LegShare:
    """Return what a segment adds for a leg with a current, as `integrals.add_leg` does."""
    begin = phase_current(frame, leg)
    end = phase_current(after, leg)
    most = max(abs(begin), abs(end))
    peak = max(peak, most)
    deviation = sagitta(circuit, length)
    if is_smooth and abs(end - begin) > 8.0 * deviation:
        if begin * end >= 0.0:
            return LegShare(abs(charge), peak, 0.0)
        standing_phase_series(series, leg, count)
        zero = _zero_of_monotone(series, count, begin, end)
        first = length * integral_to(series.other, count, zero)
        return LegShare(abs(first) + abs(charge - first), peak, zero)
    least = min(begin, end) if begin > 0.0 else -max(begin, end)
    keeps_sign = is_smooth and least > deviation
    stays_below = is_smooth and most + deviation <= peak
    if not (keeps_sign and stays_below):
        standing_phase_series(series, leg, count)
    magnitude, peak = magnitude_and_peak(series, charge, count, length, keeps_sign, stays_below, peak)
    return LegShare(magnitude, peak, 0.0)


@inlined
def _exchanged_about(series: Series, link: LinkState, count: int, zero: float, power: float) -> float:
    """Return the integral of the magnitude of the bridge's power, per segment length (W).

    `zero`: share at which the current in `other` crosses zero (1). `power`: mean power, with the sign of that current
    at the end (W).
    """
    first = 0.0
    for n in range(_SIX_POINTS, _SIX_POINTS + 6):
        place = zero * _ALL_PLACES[n]
        current = value_at(series.other, count, place)
        first += _ALL_WEIGHTS[n] * (value_at(link.voltage, count, place) * current)
    first *= zero
    return abs(first) + abs(power - first)


@inlined
def _values_at(series: Series, link: LinkState, count: int, place: float) -> tuple[float, float, float]:
    """Return voltage (V) and currents along and across the first phase's axis (A) at a share of a segment."""
    voltage = along = across = 0.0
    for k in range(count - 1, -1, -1):
        voltage = voltage * place + link.voltage[k]
        along = along * place + series.direct[k]
        across = across * place + series.quadrature[k]
    return voltage, along, across


@inlined
def _source_current(feed: Feed, link: LinkState, voltage: float, count: int, place: float) -> float:
    """Return the current of the source (A) at a share of a segment, where the link has this voltage (V)."""
    if feed.per_inductance != 0.0:
        return value_at(link.source, count, place)
    return (feed.source - voltage) * feed.per_resistance


@inlined
def _exchanged(series: Series, link: LinkState, count: int) -> float:
    """Return the integral of the magnitude of the bridge's power, per segment length (W), where it changes its sign."""
    terms = min(2 * count - 1, TERMS)
    for k in range(terms):
        product = 0.0
        for n in range(max(0, k - count + 1), min(k, count - 1) + 1):
            product += link.voltage[n] * link.bridge[k - n]
        series.other[k] = product
    return magnitude_of(series, terms)


@inlined
def _extend_voltage_range(series: Series, link: LinkState, count: int) -> None:
    """Extend the range of the link's voltage by that of a segment."""
    totals = link.totals
    lowest, highest, is_exact = voltage_range(link, count)
    if highest > totals[dc_link.HIGHEST] or lowest < totals[dc_link.LOWEST]:
        if not is_exact:
            lowest, highest = extremes(link.voltage, count, series.slopes)
        totals[dc_link.HIGHEST] = max(totals[dc_link.HIGHEST], highest)
        totals[dc_link.LOWEST] = min(totals[dc_link.LOWEST], lowest)


@inlined
def _add_link(
    constants: DcLink,
    feed: Feed,
    link: LinkState,
    length: float,
    sums: tuple[float, float, float, float, float],
) -> None:
    """Add a segment to the link's ledger.

    `sums`: means over the segment of voltage (V), its square (V2), the source's current (A), its square (A2) and the
    bridge's current (A).
    """
    voltage, square, current, current_square, bridge = sums
    totals = link.totals
    drawn = length * feed.source * current
    resisted = length * constants.source_resistance * current_square
    chopper = constants.chopper_conductance if link.state[CHOPPER] != 0.0 else 0.0
    burnt = length * chopper * square
    lost = feed.conductance - chopper
    totals[dc_link.DRAWN] += drawn
    totals[dc_link.RESISTED] += resisted
    totals[dc_link.BURNT] += burnt
    totals[dc_link.SUPPLIED] += length * lost * square
    totals[dc_link.SOURCE_CHARGE] += length * current
    totals[dc_link.BRIDGE_CHARGE] += length * (bridge + lost * voltage)
    totals[dc_link.FLUX] += length * voltage
    totals[dc_link.THROUGHPUT] += abs(drawn) + resisted + length * feed.conductance * square


@unallocating
def add_linked_segment(
    drive: PmAcDrive,
    circuit: Circuit,
    feed: Feed,
    legs: Legs,
    series: Series,
    link: LinkState,
    frame: RotorFrame,
    after: RotorFrame,
    held: int,
    count: int,
    length: float,
    magnitudes: NDArray[np.float64],
    bounds: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add a segment to the ledgers of machine and link; arguments as of `integrals.add_segment`.

    `held` may be `EMPTY`: then only the link has a share.
    """
    offset, points = _rule(circuit.rate * length, held == FREE)
    supply = supply_leg(legs, held) if held != EMPTY else -1
    direction = 0.0
    if supply >= 0:
        direction = 1.0 if is_on_upper_rail(legs.gates[supply], legs.signs[supply]) else -1.0
    square = product = quadrature_sum = along = across = 0.0
    voltage_sum = voltage_square = current_sum = current_square = bridge_sum = power = 0.0
    for n in range(offset, offset + points):
        place = _ALL_PLACES[n]
        weight = _ALL_WEIGHTS[n]
        if held == EMPTY:
            voltage, current_a, current_b = value_at(link.voltage, count, place), 0.0, 0.0
        else:
            voltage, current_a, current_b = _values_at(series, link, count, place)
        voltage_sum += weight * voltage
        voltage_square += weight * (voltage * voltage)
        current = _source_current(feed, link, voltage, count, place)
        current_sum += weight * current
        current_square += weight * (current * current)
        if held == EMPTY:
            continue
        by_cosine, by_sine = small_cosine_sine(circuit.electrical * length * place)
        cosine, sine = turned(frame, by_cosine, by_sine)
        quadrature = cosine * current_b - sine * current_a
        square += weight * (current_a * current_a + current_b * current_b)
        product += weight * ((cosine * current_a + sine * current_b) * quadrature)
        quadrature_sum += weight * quadrature
        along += weight * current_a
        across += weight * current_b
        if supply >= 0:
            bridge = direction * of_phase(supply, current_a, current_b)
            bridge_sum += weight * bridge
            power += weight * (voltage * bridge)
    _add_link(
        drive.dc_link,
        feed,
        link,
        length,
        (voltage_sum, voltage_square, current_sum, current_square, bridge_sum),
    )
    _extend_voltage_range(series, link, count)
    if held == EMPTY:
        return
    saliency = drive.direct_inductance - drive.quadrature_inductance
    totals[ledger.SQUARE] += 1.5 * length * square
    totals[ledger.IMPULSE] += (
        1.5 * drive.pole_pairs * length * (circuit.flux * quadrature_sum + saliency * product)
    )
    along, across = length * along, length * across
    peak = totals[ledger.PEAK]
    exchanged = abs(length * power)
    for leg in range(3):
        if leg == held:
            continue
        charge = of_phase(leg, along, across)
        share = _leg_share(circuit, series, frame, after, leg, charge, count, length, held == FREE, peak)
        peak = share.peak
        add_magnitude(circuit, legs, leg, share.magnitude, magnitudes, totals)
        if leg == supply and share.magnitude - abs(charge) > _ROUNDING * share.magnitude:
            if share.zero > 0.0:
                exchanged = length * _exchanged_about(series, link, count, share.zero, direction * power)
            else:
                exchanged = length * _exchanged(series, link, count)
    totals[ledger.PEAK] = peak
    drawn = length * power
    add_exchange(drawn, exchanged, totals)
    link.totals[dc_link.BRIDGE] += drawn
    link.totals[dc_link.THROUGHPUT] += exchanged
    if bounds.size > 0:
        turn_into_rotor_frame(circuit, series, frame, count, length)
        extend_torque_range(drive, series, count, bounds)
