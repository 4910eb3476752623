"""One phase on its half-bridge leg, advanced exactly from event to event.

Within a control period the speed, the commands and the supply are constant. The leg follows the paper's
per-phase hysteresis current controllers ("Implementation", Fig. 8) on the split supply of Table 1: in its
positive window the upper switch is on until the current reaches i* + h, then off until it falls to
max(i* - h, 0); the lower switch is the mirror image in the negative window. With the gates off a current
flows on through the freewheeling diode of the other rail; without a current the phase floats, or rectifies
once its back-EMF exceeds the rail. h = 0 is the ideal regulator, whose current slides along i*.
"""

from __future__ import annotations

from math import floor, inf, pi

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.leg import connection, ideal_latch, time_to_pass
from drivegate_models.half_bridge.plant.segments import keep_segment
from drivegate_models.machine import ledger
from drivegate_models.machine.winding_current import (
    LONGEST,
    crossing_time,
    current_after,
    current_integrals,
    turning_time,
)

COMPLETED = 0
"""Status: the advance reached its end."""
TOO_MANY_EVENTS = 1
"""Status: the phase switched more often than the limit allows (a harness fault, never a candidate's)."""
EVENT_LIMIT = 200_000
"""Greatest number of events of one phase in one advance."""

_STANDSTILL = 1e-100
_LEAST_REFERENCE = 1e-20


@inlined
def _wrapped(angle: float) -> float:
    """Return an angle in [0, 2 pi) (rad)."""
    turns = floor(angle * (0.5 / pi))
    return max(angle - 2.0 * pi * turns, 0.0)


@inlined
def _corner_before(corners: NDArray[np.float64], angle: float) -> int:
    """Return the index of the corner at or before an angle, by bisection."""
    low = 0
    high = corners.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if corners[middle] <= angle:
            low = middle
        else:
            high = middle
    return low


@inlined
def _window_state(angle: float, window: float) -> tuple[int, float, int]:
    """Return the sector (1, -1, 0 between windows) at an advanced angle, the angle to its end, the next window."""
    position = _wrapped(angle - 0.5 * (pi - window))
    if position < window:
        return 1, window - position, -1
    if position < pi:
        return 0, pi - position, -1
    if position < pi + window:
        return -1, pi + window - position, 1
    return 0, 2.0 * pi - position, 1


@inlined
def _compared(latch: int, magnitude: float, reference: float, band: float) -> int:
    """Return the latch after both comparators have looked at the current along the sector's sign."""
    if magnitude >= reference + band:
        return 0
    if magnitude <= max(reference - band, 0.0):
        return 1
    return latch


@inlined
def advance_phase(
    drive: Drive,
    corners: NDArray[np.float64],
    corner_values: NDArray[np.float64],
    corner_slopes: NDArray[np.float64],
    phase: int,
    currents: NDArray[np.float64],
    sectors: NDArray[np.int64],
    latches: NDArray[np.int64],
    angle: float,
    speed: float,
    upper: float,
    lower: float,
    reference: float,
    advance: float,
    duration: float,
    totals: NDArray[np.float64],
    rows: NDArray[np.float64],
    row_count: NDArray[np.int64],
) -> int:
    """Advance one phase by a control period, solving every event in it.

    Parameters
    ----------
    drive : Drive
        The drive's constants.
    corners, corner_values, corner_slopes : ndarray
        The drive's `emf_angles`, `emf_values` and `emf_slopes`; taken out of it once by the caller, since
        every look at an array in a tuple counts a reference.
    phase : int
        Index of the phase, 0 to m - 1.
    currents : ndarray, shape (m,)
        Phase currents (A), updated.
    sectors, latches : ndarray of int64, shape (m,)
        Window that each phase is in (1, 0, -1) and whether its comparator is latched on (1, 0), updated.
    angle : float
        Electrical angle of this phase at the start (rad).
    speed : float
        Shaft speed (rad/s), at least 0.
    upper, lower : float
        Voltages of the half-sources (V).
    reference : float
        Current reference i* (A); 0 blocks the gates.
    advance : float
        Advance angle (rad electrical).
    duration : float
        Length of the advance (s).
    totals : ndarray, shape (ledger.ENTRIES,)
        Exact integrals, added to.
    rows : ndarray, shape (m, n, segments.FIELDS)
        Receives the segments; n = 0 keeps none.
    row_count : ndarray of int64, shape (m,)
        Number of segments kept of each phase, set.

    Returns
    -------
    int
        `COMPLETED` or `TOO_MANY_EVENTS`.
    """
    two_pi = 2.0 * pi
    resistance = drive.resistance
    inverse_inductance = 1.0 / drive.inductance
    rate = resistance * inverse_inductance
    band = drive.hysteresis_band
    electrical = drive.pole_pairs * speed
    if electrical < _STANDSTILL:
        # So slow that the time of a radian is no number any more.
        electrical = 0.0
    if reference < _LEAST_REFERENCE:
        # Such a current comes and goes within the rounding of time; the gates stay blocked, as at zero.
        reference = 0.0
    emf_peak = drive.emf_constant * speed
    switch_drop = drive.switch_drop
    diode_drop = drive.diode_drop
    longest = LONGEST / rate if rate > 0.0 else inf
    kept = 0

    angle = _wrapped(angle)
    last = corners.size - 2
    corner = _corner_before(corners, angle)
    per_radian = 1.0 / electrical if electrical > 0.0 else inf
    turn_base = -angle
    corner_time = (corners[corner] + turn_base) * per_radian if electrical > 0.0 else 0.0
    next_corner_time = (corners[corner + 1] + turn_base) * per_radian if electrical > 0.0 else inf
    shape_start = corner_values[corner]
    shape_rate = corner_slopes[corner] * electrical
    if electrical == 0.0:
        shape_start = shape_start + corner_slopes[corner] * (angle - corners[corner])

    sector, to_edge, next_sector = _window_state(angle + advance, drive.window)
    edge_time = to_edge * per_radian if electrical > 0.0 else inf
    current = currents[phase]
    latch = latches[phase]
    gate_was = sectors[phase] * latch
    if reference <= 0.0:
        gate_was = 0
    if sector != sectors[phase]:
        latch = 1
    if sector != 0:
        latch = _compared(latch, sector * current, reference, band)

    time = 0.0
    depart = 0
    conducting = 0
    events = 0
    peak = abs(current)
    magnitude_total = 0.0
    square_total = 0.0
    shape_current_total = 0.0
    upper_total = 0.0
    lower_total = 0.0
    exchanged_total = 0.0
    returned_total = 0.0
    device_total = 0.0
    switching_total = 0.0
    core_total = 0.0
    drag_total = 0.0

    while time < duration:
        events += 1
        if events > EVENT_LIMIT:
            return TOO_MANY_EVENTS
        shape = shape_start + shape_rate * (time - corner_time)
        emf = emf_peak * shape
        emf_rate = emf_peak * shape_rate

        front_source = upper if sector > 0 else lower
        back_source = lower if sector > 0 else upper
        slides = False
        gate = 0
        if sector != 0 and reference > 0.0:
            if band == 0.0:
                latch, depart, slides = ideal_latch(
                    sector * current,
                    reference,
                    depart,
                    sector * emf + resistance * reference,
                    front_source - switch_drop,
                    -(back_source + diode_drop),
                )
            gate = sector * latch
        if gate != gate_was:
            if band > 0.0:
                switching_total += drive.turn_off_energy if gate_was != 0 else 0.0
                switching_total += drive.turn_on_energy if gate != 0 else 0.0
            gate_was = gate
        rail = 0
        side = 0
        if not slides:
            rail, side = connection(
                gate, current, conducting, emf, emf_rate, upper, lower, switch_drop, diode_drop
            )
        from_rest = conducting
        conducting = 0

        limit = min(duration, next_corner_time, edge_time)
        length = max(limit - time, 0.0)
        at_limit = True

        if slides:
            front = front_source - switch_drop
            back = back_source + diode_drop
            needed = sector * emf + resistance * reference
            needed_rate = sector * emf_rate
            wait = time_to_pass(needed, needed_rate, -back, front)
            if wait < length:
                length = max(wait, 0.0)
                at_limit = False
                depart = -1 if needed_rate > 0.0 else 1
            if length > 0.0:
                # The switch's share of time, the limit of a band that shrinks to nothing.
                share = (needed + 0.5 * needed_rate * length + back) / (front + back)
                charge = reference * length
                magnitude_total += charge
                square_total += reference * charge
                shape_current_total += sector * (shape + 0.5 * shape_rate * length) * charge
                taken = share * front_source * charge
                given = (1.0 - share) * back_source * charge
                if sector > 0:
                    upper_total += taken
                    lower_total -= given
                else:
                    lower_total += taken
                    upper_total -= given
                exchanged_total += taken + given
                returned_total += given
                device_total += (share * switch_drop + (1.0 - share) * diode_drop) * charge
                drop = resistance * reference
                core_total += (share * (front - drop) ** 2 + (1.0 - share) * (back + drop) ** 2) * length
                held = sector * needed
                kept = keep_segment(
                    rows, phase, kept, time, length, current, 0.0, 0.0, shape, shape_rate, held, emf_rate, 0.0
                )
        elif rail == 0:
            # Until the back-EMF passes a rail (or, with forward drops, leaves the dead zone of a closed switch).
            high = upper + diode_drop if gate >= 0 else -(lower - switch_drop)
            low = -(lower + diode_drop) if gate <= 0 else upper - switch_drop
            wait = time_to_pass(emf, emf_rate, low, high)
            if wait < length:
                length = max(wait, 0.0)
                at_limit = False
                conducting = -1 if emf_rate > 0.0 else 1
            if length > 0.0:
                drag_total += length * (
                    shape * shape + shape_rate * length * (shape + shape_rate * length / 3.0)
                )
                kept = keep_segment(
                    rows, phase, kept, time, length, 0.0, 0.0, 0.0, shape, shape_rate, emf, emf_rate, 0.0
                )
        else:
            if length > longest:
                length = longest
                at_limit = False
            source = upper if rail > 0 else lower
            returning = rail * side < 0
            voltage = rail * (source + diode_drop if returning else source - switch_drop)
            slope = (voltage - emf - resistance * current) * inverse_inductance
            curvature = emf_rate * inverse_inductance
            if from_rest != 0 or (current == 0.0 and side * slope < 0.0):
                slope = 0.0
            elif depart * sector * slope < 0.0:
                # Leaving a slide: what is left of the slope is rounding.
                slope = 0.0
            depart = 0
            end_current, end_slope = current_after(current, slope, curvature, rate, length)

            zero_time = crossing_time(
                current, slope, curvature, rate, length, end_current, end_slope, 0.0, side < 0
            )
            level = 0.0
            level_time = inf
            if gate != 0:
                if side == gate:
                    level = gate * (reference + band)
                    level_time = crossing_time(
                        current, slope, curvature, rate, length, end_current, end_slope, level, gate > 0
                    )
            elif sector != 0 and reference > 0.0 and side == sector:
                level = sector * max(reference - band, 0.0)
                if level != 0.0:
                    level_time = crossing_time(
                        current, slope, curvature, rate, length, end_current, end_slope, level, sector < 0
                    )
            at_level = level_time <= zero_time and level_time <= length
            at_zero = not at_level and zero_time <= length
            if at_level:
                length = level_time
                at_limit = False
            elif at_zero:
                length = zero_time
                at_limit = False

            if length > 0.0:
                end_current, end_slope, first, second, square = current_integrals(
                    current, slope, curvature, rate, length
                )
                if slope * end_slope < 0.0:
                    turn = turning_time(slope, curvature, rate)
                    extreme, _ = current_after(current, slope, curvature, rate, turn)
                    peak = max(peak, abs(extreme))
                magnitude = side * first
                magnitude_total += magnitude
                square_total += square
                shape_current_total += (shape + shape_rate * length) * first - shape_rate * second
                energy = rail * source * first
                if rail > 0:
                    upper_total += energy
                else:
                    lower_total += energy
                exchanged_total += source * magnitude
                if returning:
                    returned_total += source * magnitude
                device_total += (diode_drop if returning else switch_drop) * magnitude
                core_total += voltage * (voltage * length - 2.0 * resistance * first)
                core_total += resistance * resistance * square
                kept = keep_segment(
                    rows,
                    phase,
                    kept,
                    time,
                    length,
                    current,
                    slope,
                    curvature,
                    shape,
                    shape_rate,
                    voltage,
                    0.0,
                    rate,
                )
                current = end_current
            if at_level:
                current = level
                latch = 0 if gate != 0 else 1
            elif at_zero:
                current = 0.0
                if gate == 0 and side == sector and 0.0 < reference <= band:
                    # The comparator's lower edge is at zero.
                    latch = 1
            peak = max(peak, abs(current))

        if at_limit:
            time = limit
        else:
            time += length
        while time >= next_corner_time:
            corner += 1
            if corner > last:
                corner = 0
                turn_base += two_pi
            corner_time = (corners[corner] + turn_base) * per_radian
            next_corner_time = (corners[corner + 1] + turn_base) * per_radian
            shape_start = corner_values[corner]
            shape_rate = corner_slopes[corner] * electrical
        while time >= edge_time:
            if sector != 0:
                next_sector = -sector
                sector = 0
                edge_time += (pi - drive.window) * per_radian
            else:
                sector = next_sector
                latch = _compared(1, sector * current, reference, band)
                edge_time += drive.window * per_radian
            depart = 0

    currents[phase] = current
    sectors[phase] = sector
    latches[phase] = latch
    row_count[phase] = kept
    totals[ledger.MAGNITUDE] += magnitude_total
    totals[ledger.SQUARE] += square_total
    totals[ledger.IMPULSE] += drive.emf_constant * shape_current_total
    totals[ledger.UPPER] += upper_total
    totals[ledger.LOWER] += lower_total
    totals[ledger.EXCHANGED] += exchanged_total
    totals[ledger.RETURNED] += returned_total
    totals[ledger.DEVICE] += device_total
    totals[ledger.SWITCHING] += switching_total
    totals[ledger.CORE_SOURCE] += drive.core_loss_conductance * core_total
    drag = drive.core_loss_conductance * drive.emf_constant * emf_peak * drag_total
    totals[ledger.CORE_DRAG_IMPULSE] += drag
    totals[ledger.PEAK] = max(totals[ledger.PEAK], peak)
    totals[ledger.EVENTS] += events
    return COMPLETED
