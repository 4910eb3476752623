"""Integrals of one stretch for the ledger, phase by phase, and its segments."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.machine.segments import store_segment
from drivegate_models.machine.winding_current import (
    Phis,
    Squares,
    current_after,
    integrals_by,
    phis_at,
    squares_at,
    turning_time,
)
from drivegate_models.star.plant.neutral import Neutral, shared_middle
from drivegate_models.star.plant.places import HELD
from drivegate_models.star.plant.staircase import HIGHEST, LOWEST, MIDDLE, Circuit, tread_voltage


class Span(NamedTuple):
    """A stretch, and the linear motion of the neutral in it."""

    start: float
    """Start, from the beginning of the advance (s)."""
    length: float
    """Length of the stretch (s)."""
    neutral: float
    """Voltage of the neutral at the start (V)."""
    neutral_rate: float
    """Rate of the neutral's voltage (V/s)."""
    ripple_share: float
    """Share of a chopping phase's mean square voltage ripple across the windings (1)."""


@inlined
def span_of(places: NDArray[Any], neutral: Neutral, start: float, length: float) -> Span:
    """Return a stretch with the motion of the neutral in it.

    `start`, `length`: start from the beginning of the advance, and length (s). Result: while every phase is held, the
    neutral is undetermined within the intersection of their intervals. It is set to the middle, where two chopping
    phases have equal shares, like comparators on equal currents.
    """
    if neutral.moving == 0:
        begin = shared_middle(places, 0.0)
        rate = (shared_middle(places, length) - begin) / length if length > 0.0 else 0.0
        return Span(start, length, begin, rate, 1.0)
    # A phase that chops alone moves the neutral: of its ripple u, u (n - 1)/n is across its own winding, and u/n across
    # each of the others.
    return Span(start, length, neutral.voltage, neutral.rate, 1.0 - 1.0 / neutral.connected)


@inlined
def _slide(
    circuit: Circuit,
    place: Any,
    span: Span,
    current: float,
    totals: NDArray[np.float64],
) -> float:
    """Add a phase whose current the ideal regulator maintains; return the integral of its magnitude (A s)."""
    gate = place.gate
    length = span.length
    source = circuit.source
    front = tread_voltage(circuit, gate, MIDDLE)
    back = tread_voltage(circuit, gate, HIGHEST if gate > 0 else LOWEST)
    voltage = span.neutral + place.opposed
    # The switch's duty ratio, the limit of a vanishing band; it is linear in time.
    share = (voltage - back) / (front - back)
    end_share = share + (span.neutral_rate + place.opposed_rate) * length / (front - back)
    mean_share = 0.5 * (share + end_share)
    charge = abs(current) * length
    drawn = mean_share * source * charge
    returned = (1.0 - mean_share) * source * charge
    totals[ledger.UPPER] += drawn if gate > 0 else -returned
    totals[ledger.LOWER] += -returned if gate > 0 else drawn
    totals[ledger.MAGNITUDE] += charge
    totals[ledger.SQUARE] += current * current * length
    totals[ledger.EXCHANGED] += drawn + returned
    totals[ledger.RETURNED] += returned
    totals[ledger.DEVICE] += (
        mean_share * circuit.switch_drop + (1.0 - mean_share) * circuit.diode_drop
    ) * charge
    shape = place.emf_shape
    shape_end = shape + place.shape_rate * length
    totals[ledger.IMPULSE] += circuit.emf_constant * 0.5 * (shape + shape_end) * current * length
    squares = (shape * shape + shape * shape_end + shape_end * shape_end) / 3.0
    ripple = mean_share - (share * share + share * end_share + end_share * end_share) / 3.0
    totals[ledger.CORE_SOURCE] += (
        circuit.core_loss_conductance
        * length
        * (
            circuit.emf_peak * circuit.emf_peak * squares
            + span.ripple_share * (front - back) * (front - back) * ripple
        )
    )
    return charge


@inlined
def _drag(circuit: Circuit, place: Any, length: float, totals: NDArray[np.float64]) -> None:
    """Add the drag of a phase without current, whose core loss the shaft supplies."""
    shape = place.emf_shape
    shape_end = shape + place.shape_rate * length
    squares = length * (shape * shape + shape * shape_end + shape_end * shape_end) / 3.0
    totals[ledger.CORE_DRAG_IMPULSE] += (
        circuit.core_loss_conductance * circuit.emf_constant * circuit.emf_peak * squares
    )


@inlined
def _conduct(
    circuit: Circuit,
    place: Any,
    span: Span,
    current: float,
    phis: Phis,
    squares: Squares,
    totals: NDArray[np.float64],
) -> tuple[float, float]:
    """Add a phase whose current moves; return its current at the end (A) and the integral of its magnitude (A s)."""
    length = span.length
    slope = place.slope
    curvature = place.curvature
    end, end_slope, first, second, square = integrals_by(current, slope, curvature, length, phis, squares)
    peak = max(totals[ledger.PEAK], abs(end))
    if slope * end_slope < 0.0:
        turn = turning_time(slope, curvature, circuit.rate)
        extreme, _ = current_after(current, slope, curvature, circuit.rate, turn)
        peak = max(peak, abs(extreme))
    totals[ledger.PEAK] = peak
    tread = place.tread
    returning = tread != MIDDLE
    # Relative to the link's middle, a diode leads to the rail that its current opposes.
    rail = place.gate if tread == MIDDLE else (1 if tread == LOWEST else -1)
    magnitude = -rail * first if returning else rail * first
    energy = rail * circuit.source * first
    if rail > 0:
        totals[ledger.UPPER] += energy
    else:
        totals[ledger.LOWER] += energy
    totals[ledger.MAGNITUDE] += magnitude
    totals[ledger.SQUARE] += square
    totals[ledger.EXCHANGED] += circuit.source * magnitude
    if returning:
        totals[ledger.RETURNED] += circuit.source * magnitude
    totals[ledger.DEVICE] += (circuit.diode_drop if returning else circuit.switch_drop) * magnitude
    shape_end = place.emf_shape + place.shape_rate * length
    totals[ledger.IMPULSE] += circuit.emf_constant * (shape_end * first - place.shape_rate * second)
    # Gap voltage v - v_n - R i: a straight line minus R i.
    line = tread_voltage(circuit, place.gate, tread) - span.neutral
    fall = span.neutral_rate
    lines = length * (line * line - fall * length * (line - fall * length / 3.0))
    products = line * first - fall * (length * first - second)
    resistance = circuit.resistance
    totals[ledger.CORE_SOURCE] += circuit.core_loss_conductance * (
        lines - resistance * (2.0 * products - resistance * square)
    )
    return end, magnitude


@inlined
def add_stretch(
    circuit: Circuit,
    places: NDArray[Any],
    span: Span,
    currents: NDArray[np.float64],
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
    rows: NDArray[np.float64],
    row_counts: NDArray[np.int64],
) -> None:
    """Add a stretch to the ledger, store its segments, and advance every current to its end.

    `currents`, shape (m,): phase currents (A); updated to the end of the stretch. `magnitudes`, shape (m,): the
    integrals of the currents' magnitudes (A s) are added to it. `totals`, shape (ledger.ENTRIES,): the exact integrals
    of all phases are added to it. `rows`, `row_counts`: receive the segments, as in `machine.segments`.
    """
    # All phases have the same R/L, and so the same series.
    x = circuit.rate * span.length
    phis = phis_at(x)
    squares = squares_at(x)
    for k in range(places.size):
        place = places[k]
        current = currents[k]
        if place.tread == HELD:
            voltage = span.neutral + place.opposed
            voltage_rate = span.neutral_rate + place.opposed_rate
            rate = 0.0
            if current == 0.0:
                _drag(circuit, place, span.length, totals)
            else:
                magnitudes[k] += _slide(circuit, place, span, current, totals)
        else:
            voltage = tread_voltage(circuit, place.gate, place.tread)
            voltage_rate = 0.0
            rate = circuit.rate
            currents[k], magnitude = _conduct(circuit, place, span, current, phis, squares, totals)
            magnitudes[k] += magnitude
        row_counts[k] = store_segment(
            rows,
            k,
            row_counts[k],
            span.start,
            span.length,
            current,
            place.slope,
            place.curvature,
            place.emf_shape,
            place.shape_rate,
            voltage,
            voltage_rate,
            rate,
        )
