"""Advance of all phases of the star at constant speed, supply and command, from event to event."""

from __future__ import annotations

from math import inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import called, inlined, unallocating
from drivegate_models.machine import ledger, segments
from drivegate_models.machine.advance_status import COMPLETED, TOO_MANY_EVENTS
from drivegate_models.machine.cycle import Shape, next_shape, shape_at, wrapped
from drivegate_models.machine.winding_current import LONGEST
from drivegate_models.star.plant.drive import StarDrive
from drivegate_models.star.plant.events import Event, first_event
from drivegate_models.star.plant.integrals import add_stretch, span_of
from drivegate_models.star.plant.neutral import settle
from drivegate_models.star.plant.places import HELD, make_places
from drivegate_models.star.plant.regulation import gate_of, regulate
from drivegate_models.star.plant.staircase import Circuit
from drivegate_models.star.plant.window import GAP, next_piece, piece_at

EVENT_LIMIT = 1_000_000

_STANDSTILL = 1e-100
_LEAST_REFERENCE = 1e-20
_SAME_ANGLE = 2.0 * pi * 1e-13
"""Maximum distance of corners and window edges that are one event (rad electrical)."""
_NEAR = 1e-13
"""Distance from a level that counts as zero, relative to the scale of a current in its stretch."""
_ROUNDING = 1e-15


class StarPhases(NamedTuple):
    """State of the m phases and space for the segments of one advance; the arrays are updated in place."""

    currents: NDArray[np.float64]
    """Phase currents, shape (m,) (A); they sum to zero."""
    pieces: NDArray[np.int64]
    """Piece of the conduction windows of each phase, shape (m,)."""
    latches: NDArray[np.int64]
    """Comparator of each phase, shape (m,): 1 on, 0 off."""
    magnitudes: NDArray[np.float64]
    """Integral of each phase's current magnitude over the last advance, shape (m,) (A s)."""
    rows: NDArray[np.float64]
    """Segments of the last advance, shape (m, n, segments.FIELDS); with n = 0 none are stored."""
    row_counts: NDArray[np.int64]
    """Number of segments of each phase, shape (m,)."""
    places: NDArray[Any]
    """Work space for the state of each phase between two events, shape (m,) of `places.PLACE`."""
    bounds: NDArray[np.float64]
    """Work space for intervals, shape (2, m)."""


def make_phases(drive: StarDrive, longest_advance: float = 0.0) -> StarPhases:
    """Return phases at rest: no current, latches on.

    `longest_advance`: maximum length of an advance whose segments are stored (s), with space for every segment that the
    drive can produce in that time; 0 to store none.
    """
    count = drive.phases
    capacity = 0
    if longest_advance > 0.0:
        # An event of any phase ends the segments of all phases.
        band = drive.hysteresis_band
        swing = 2.5 * drive.half_supply_voltage / drive.inductance
        chops = longest_advance * swing / band if band > 0.0 else 0.0
        capacity = 64 + count * (8 * drive.emf_slopes.size + int(2.0 * chops))
    return StarPhases(
        currents=np.zeros(count),
        pieces=np.full(count, GAP, np.int64),
        latches=np.ones(count, np.int64),
        magnitudes=np.zeros(count),
        rows=np.zeros((count, capacity, segments.FIELDS)),
        row_counts=np.zeros(count, np.int64),
        places=make_places(count),
        bounds=np.zeros((2, count)),
    )


@inlined
def _set_shape(place: Any, shape: Shape) -> None:
    place.corner = shape.corner
    place.turn = shape.turn
    place.shape_begin = shape.begin
    place.shape_end = shape.end
    place.shape_start = shape.start
    place.shape_rate = shape.rate


@inlined
def _circuit(drive: StarDrive, speed: float, upper: float, lower: float, reference: float) -> Circuit:
    inverse_inductance = 1.0 / drive.inductance
    rate = drive.resistance * inverse_inductance
    return Circuit(
        drive.resistance,
        inverse_inductance,
        rate,
        LONGEST / rate if rate > 0.0 else inf,
        # Without a tap between the halves only their sum acts.
        0.5 * (upper + lower),
        drive.switch_drop,
        drive.diode_drop,
        # A smaller current rises and falls within the rounding of time; the gates remain blocked, as at zero.
        reference if reference >= _LEAST_REFERENCE else 0.0,
        drive.hysteresis_band,
        drive.window,
        drive.regulation,
        drive.turn_on_energy,
        drive.turn_off_energy,
        drive.emf_constant,
        drive.emf_constant * speed,
        drive.core_loss_conductance,
    )


@inlined
def _place_phase(
    circuit: Circuit,
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    place: Any,
    piece_was: int,
    latch: int,
    angle: float,
    advance: float,
    electrical: float,
) -> None:
    """Set corner, window and comparator of a phase at the start of an advance."""
    angle = wrapped(angle)
    _set_shape(place, shape_at(corners, corner_values, corner_slopes, angle, electrical))
    place.piece, place.piece_end = piece_at(angle + advance, circuit.window, circuit.regulation, electrical)
    place.gate = gate_of(circuit, piece_was, latch)
    # A latch is on when its window opens, whatever it was in the preceding one.
    place.latch = latch if place.piece == piece_was else 1
    place.reached = 0


@inlined
def _pass_edges(
    circuit: Circuit,
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    place: Any,
    until: float,
    electrical: float,
) -> None:
    """Move a phase past every corner and window edge up to a time (s)."""
    while until >= place.shape_end:
        shape = Shape(
            place.corner, place.turn, place.shape_begin, place.shape_end, place.shape_start, place.shape_rate
        )
        _set_shape(place, next_shape(corners, corner_values, corner_slopes, shape, electrical))
    while until >= place.piece_end:
        place.piece, place.piece_end = next_piece(
            place.piece, place.piece_end, circuit.window, circuit.regulation, electrical
        )
        place.latch = 1


@unallocating
def _pass_all(
    circuit: Circuit,
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    places: NDArray[Any],
    until: float,
    electrical: float,
) -> None:
    """Move every phase past its corners and window edges up to a time (s)."""
    for k in range(places.size):
        _pass_edges(circuit, corners, corner_values, corner_slopes, places[k], until, electrical)


@inlined
def _oppose(circuit: Circuit, places: NDArray[Any], currents: NDArray[np.float64], time: float) -> float:
    """Set back-EMF and e + R i of every phase at a time; return the time of the next corner or edge (s)."""
    limit = inf
    for k in range(places.size):
        place = places[k]
        place.emf_shape = place.shape_start + place.shape_rate * (time - place.shape_begin)
        place.start = currents[k]
        place.opposed = circuit.emf_peak * place.emf_shape + circuit.resistance * currents[k]
        place.opposed_rate = circuit.emf_peak * place.shape_rate
        limit = min(limit, place.shape_end, place.piece_end)
    return limit


@inlined
def _near_level(place: Any, current: float, length: float) -> float:
    """Return the level that a current has reached except for rounding, or the current itself (A)."""
    start = place.start
    near = _NEAR * max(abs(current), abs(start), abs(place.slope) * length)
    if start != place.ceiling and abs(current - place.ceiling) <= near:
        return float(place.ceiling)
    if start != place.floor and abs(current - place.floor) <= near:
        return float(place.floor)
    return current


@inlined
def _sum_and_size(currents: NDArray[np.float64]) -> tuple[float, float]:
    total = 0.0
    size = 0.0
    for k in range(currents.size):
        total += currents[k]
        size += abs(currents[k])
    return total, size


@inlined
def _land(
    places: NDArray[Any],
    currents: NDArray[np.float64],
    event: Event,
    length: float,
) -> None:
    """Set the currents that have reached a level to that level, and correct the sum by the largest other current.

    `currents`, shape (m,): phase currents at the end of the stretch (A), updated. `length`: length of the stretch (s).
    """
    free = -1
    near = -1
    for k in range(places.size):
        place = places[k]
        if place.tread == HELD:
            continue
        if k == event.phase:
            currents[k] = event.level
            continue
        level = _near_level(place, currents[k], length)
        if level != currents[k] or level in (place.floor, place.ceiling):
            near = k if near < 0 or abs(level) > abs(currents[near]) else near
            currents[k] = level
        elif free < 0 or abs(currents[k]) > abs(currents[free]):
            free = k
    total, size = _sum_and_size(currents)
    if free >= 0:
        remainder = currents[free] - total
        # A remainder within rounding is no current: otherwise two phases would exchange it without end.
        currents[free] = remainder if abs(remainder) > _ROUNDING * size else 0.0
    elif near >= 0 and abs(total) > _ROUNDING * size:
        # Not all currents can have reached their levels at once.
        currents[near] -= total


@called
@unallocating
def advance_phases(
    drive: StarDrive,
    phases: StarPhases,
    angle: float,
    speed: float,
    upper: float,
    lower: float,
    reference: float,
    advance: float,
    duration: float,
    totals: NDArray[np.float64],
) -> int:
    """Advance all phases by a control period, solving every event in it.

    - `phases`: state before the advance; replaced by the state after it, with the segments.
    - `angle`: electrical angle of the first phase at the start (rad).
    - `speed`: constant shaft speed (rad/s), at least 0.
    - `upper`, `lower`: voltages of the halves of the link (V); only their sum acts.
    - `reference`: current reference i* (A); 0 blocks the gates.
    - `advance`: advance angle (rad electrical).
    - `duration`: length of the advance (s).
    - `totals`, shape (ledger.ENTRIES,): the exact integrals of the advance are added to it.
    - Result: `COMPLETED` or `TOO_MANY_EVENTS`.
    """
    # Read the arrays once for all events: every access to an array in a tuple counts a reference.
    corners = drive.emf_angles
    corner_values = drive.emf_values
    corner_slopes = drive.emf_slopes
    currents = phases.currents
    magnitudes = phases.magnitudes
    rows = phases.rows
    row_counts = phases.row_counts
    places = phases.places
    bounds = phases.bounds
    count = drive.phases
    electrical = drive.pole_pairs * speed
    if electrical < _STANDSTILL:
        # At this speed the time of a radian would overflow.
        electrical = 0.0
    circuit = _circuit(drive, speed, upper, lower, reference)
    same_time = _SAME_ANGLE / electrical if electrical > 0.0 else 0.0
    for k in range(count):
        _place_phase(
            circuit,
            corners,
            corner_values,
            corner_slopes,
            places[k],
            phases.pieces[k],
            phases.latches[k],
            angle - 2.0 * pi * k / count,
            advance,
            electrical,
        )
        magnitudes[k] = 0.0
        row_counts[k] = 0
        totals[ledger.PEAK] = max(totals[ledger.PEAK], abs(currents[k]))
    _pass_all(circuit, corners, corner_values, corner_slopes, places, same_time, electrical)
    status = COMPLETED
    time = 0.0
    events = 0
    while time < duration:
        events += 1
        if events > EVENT_LIMIT:
            status = TOO_MANY_EVENTS
            break
        totals[ledger.SWITCHING] += regulate(circuit, places, currents)
        limit = min(_oppose(circuit, places, currents, time), duration)
        neutral = settle(circuit, places, bounds, currents)
        length = min(limit - time, circuit.longest)
        is_whole = limit - time <= circuit.longest
        event = first_event(circuit, places, currents, neutral, length)
        if event.phase >= 0 or event.length < length:
            is_whole = False
            length = event.length
        if length > 0.0:
            span = span_of(places, neutral, time, length)
            add_stretch(circuit, places, span, currents, magnitudes, totals, rows, row_counts)
        if event.side != 0:
            places[event.phase].reached = event.side
            if event.other >= 0:
                places[event.other].reached = -event.side
        if neutral.moving > 0:
            moved = event if event.side == 0 else Event(length, -1, -1, 0.0, 0)
            _land(places, currents, moved, length)
        # Use the limit itself, not the sum, so that a corner is passed exactly once.
        time = limit if is_whole else time + length
        if time + same_time >= limit:
            _pass_all(circuit, corners, corner_values, corner_slopes, places, time + same_time, electrical)
    for k in range(count):
        phases.pieces[k] = places[k].piece
        phases.latches[k] = places[k].latch
    totals[ledger.EVENTS] += events
    return status
