"""Integrals of one segment for both ledgers of a drive whose link has a capacitor: the machine's and the link's."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.dc_link import CHOPPER, DcLink, LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.integrals import (
    FOUR_POINTS,
    PLACES,
    THREE_POINTS,
    WEIGHTS,
    add_exchange,
    add_leg,
    add_magnitude,
    extend_torque_range,
    magnitude_of,
    supply_leg,
)
from drivegate_models.pm_ac.plant.linked_series import Feed
from drivegate_models.pm_ac.plant.polynomial import extremes, value_at
from drivegate_models.pm_ac.plant.series import LONGEST, TERMS, Series
from drivegate_models.pm_ac.plant.settling import EMPTY, FREE, Legs

# The rules with 3, 4 and 5 points, and the one with 8, which is exact up to degree 15.
_ALL_PLACES: Final = (
    *PLACES,
    0.01985507175123188,
    0.10166676129318664,
    0.2372337950418355,
    0.4082826787521751,
    0.5917173212478249,
    0.7627662049581645,
    0.8983332387068134,
    0.9801449282487681,
)
_ALL_WEIGHTS: Final = (
    *WEIGHTS,
    0.050614268145188136,
    0.1111905172266872,
    0.15685332293894363,
    0.18134189168918097,
    0.18134189168918097,
    0.15685332293894363,
    0.1111905172266872,
    0.050614268145188136,
)
# Excess of the integral of a current's magnitude over the magnitude of its integral that is only rounding.
_ROUNDING = 1e-12


@inlined
def _rule(reach: float, is_free: bool) -> tuple[int, int]:
    """Return the first place and the number of places for a segment times the fastest rate (1)."""
    if is_free and reach <= THREE_POINTS:
        return 0, 3
    if is_free and reach <= FOUR_POINTS:
        return 3, 4
    if reach <= LONGEST:
        return 7, 5
    return 12, 8


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
    end = value_at(link.voltage, count, 1.0)
    lowest = min(link.voltage[0], end)
    highest = max(link.voltage[0], end)
    deviation = 0.0
    for k in range(2, count):
        deviation += 0.125 * k * (k - 1) * abs(link.voltage[k])
    if highest + deviation > totals[dc_link.HIGHEST] or lowest - deviation < totals[dc_link.LOWEST]:
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
    square = product = quadrature_sum = along = across = 0.0
    voltage_sum = voltage_square = current_sum = current_square = bridge_sum = power = 0.0
    for n in range(offset, offset + points):
        place = _ALL_PLACES[n]
        weight = _ALL_WEIGHTS[n]
        voltage = value_at(link.voltage, count, place)
        current = (feed.source - voltage) * feed.per_resistance
        voltage_sum += weight * voltage
        voltage_square += weight * voltage * voltage
        current_sum += weight * current
        current_square += weight * current * current
        if held == EMPTY:
            continue
        direct = value_at(series.direct, count, place)
        quadrature = value_at(series.quadrature, count, place)
        bridge = value_at(link.bridge, count, place)
        cosine, sine = small_cosine_sine(circuit.electrical * length * place)
        square += weight * (direct * direct + quadrature * quadrature)
        product += weight * (direct * quadrature)
        quadrature_sum += weight * quadrature
        along += weight * (cosine * direct - sine * quadrature)
        across += weight * (sine * direct + cosine * quadrature)
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
    along, across = (
        length * (frame.cosine * along - frame.sine * across),
        length * (frame.sine * along + frame.cosine * across),
    )
    supply = supply_leg(legs, held)
    peak = totals[ledger.PEAK]
    exchanged = abs(length * power)
    for leg in range(3):
        if leg == held:
            continue
        charge = of_phase(leg, along, across)
        magnitude, peak = add_leg(
            circuit, series, frame, after, leg, charge, count, length, held == FREE, peak
        )
        add_magnitude(circuit, legs, leg, magnitude, magnitudes, totals)
        if leg == supply and magnitude - abs(charge) > _ROUNDING * magnitude:
            exchanged = length * _exchanged(series, link, count)
    totals[ledger.PEAK] = peak
    drawn = length * power
    add_exchange(drawn, exchanged, totals)
    link.totals[dc_link.BRIDGE] += drawn
    link.totals[dc_link.THROUGHPUT] += exchanged
    if bounds.size > 0:
        extend_torque_range(drive, series, count, bounds)
