"""Exact advance of one phase on its half-bridge leg, from event to event.

Within a control period the speed, the commands and the supply are constant. The leg follows the paper's per-phase
hysteresis current controllers ("Implementation", Fig. 8) on the split supply of Table 1. In the positive window the
upper switch is on until the current reaches i* + h, then off until it falls to max(i* - h, 0). The lower switch is the
mirror image in the negative window. With the gates off, a current continues through the freewheeling diode of the other
rail. Without a current the phase floats, or rectifies once its back-EMF exceeds the rail. h = 0 is the ideal regulator,
whose current slides along i*.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.leg import ideal_latch
from drivegate_models.half_bridge.plant.modes import not_sliding, slide
from drivegate_models.half_bridge.plant.stretch import Demand, Motion, Stretch, Sums, Winding, no_sums
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED, TOO_MANY_EVENTS
from drivegate_models.machine.cycle import next_shape, next_window, shape_at, window_at, wrapped
from drivegate_models.machine.winding_current import LONGEST

EVENT_LIMIT = 200_000
"""Maximum number of events of one phase in one advance."""

_STANDSTILL = 1e-100
_LEAST_REFERENCE = 1e-20


@inlined
def _compared(latch: int, magnitude: float, reference: float, band: float) -> int:
    """Return the latch after both comparators have evaluated the current times the sector's sign (A)."""
    if magnitude >= reference + band:
        return 0
    if magnitude <= max(reference - band, 0.0):
        return 1
    return latch


@inlined
def _winding(drive: Drive) -> Winding:
    """Return the constants of all stretches in an advance."""
    inverse_inductance = 1.0 / drive.inductance
    rate = drive.resistance * inverse_inductance
    longest = LONGEST / rate if rate > 0.0 else inf
    return Winding(drive.resistance, inverse_inductance, rate, longest, drive.switch_drop, drive.diode_drop)


@inlined
def _regulated(
    winding: Winding,
    drive: Drive,
    stretch: Stretch,
    motion: Motion,
    sector: int,
    reference: float,
    upper: float,
    lower: float,
) -> tuple[int, bool, Motion]:
    """Return the switch that is on (1, -1, 0), True if the current slides along i*, and the motion with its latch."""
    if sector == 0 or reference <= 0.0:
        return 0, False, motion
    if drive.hysteresis_band > 0.0:
        return sector * motion.latch, False, motion
    front = (upper if sector > 0 else lower) - winding.switch_drop
    back = (lower if sector > 0 else upper) + winding.diode_drop
    needed = sector * stretch.emf + winding.resistance * reference
    latch, depart, slides = ideal_latch(
        sector * motion.current, reference, motion.depart, needed, front, -back
    )
    return sector * latch, slides, Motion(motion.current, latch, depart, motion.conducting, motion.kept)


@inlined
def _switching_energy(drive: Drive, gate_was: int, gate: int) -> float:
    """Return the loss when the switch that is on changes (J); it is 0 for the ideal regulator."""
    if drive.hysteresis_band == 0.0:
        return 0.0
    energy = drive.turn_off_energy if gate_was != 0 else 0.0
    return energy + (drive.turn_on_energy if gate != 0 else 0.0)


@inlined
def _add_to_ledger(
    totals: NDArray[np.float64], drive: Drive, emf_peak: float, sums: Sums, switching: float, events: int
) -> None:
    """Add the integrals of one phase over an advance to the totals."""
    totals[ledger.MAGNITUDE] += sums.magnitude
    totals[ledger.SQUARE] += sums.square
    totals[ledger.IMPULSE] += drive.emf_constant * sums.shape_current
    totals[ledger.UPPER] += sums.upper
    totals[ledger.LOWER] += sums.lower
    totals[ledger.EXCHANGED] += sums.exchanged
    totals[ledger.RETURNED] += sums.returned
    totals[ledger.DEVICE] += sums.device
    totals[ledger.SWITCHING] += switching
    totals[ledger.CORE_SOURCE] += drive.core_loss_conductance * sums.core
    totals[ledger.CORE_DRAG_IMPULSE] += (
        drive.core_loss_conductance * drive.emf_constant * emf_peak * sums.drag
    )
    totals[ledger.PEAK] = max(totals[ledger.PEAK], sums.peak)
    totals[ledger.EVENTS] += events


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

    - `corners`, `corner_values`, `corner_slopes`: the drive's `emf_angles`, `emf_values` and `emf_slopes`. The caller
      reads them once, because every access to an array in a tuple counts a reference.
    - `phase`: index of the phase, 0 to m - 1.
    - `currents`, shape (m,): phase currents (A), updated.
    - `sectors`, `latches`, shape (m,): window of each phase (1, 0, -1) and state of its comparator (1 on, 0 off),
      updated.
    - `angle`: electrical angle of this phase at the start (rad).
    - `speed`: shaft speed (rad/s), at least 0.
    - `upper`, `lower`: voltages of the half-sources (V).
    - `reference`: current reference i* (A); 0 blocks the gates.
    - `advance`: advance angle (rad electrical).
    - `duration`: length of the advance (s).
    - `totals`, shape (ledger.ENTRIES,): the exact integrals of the advance are added to it.
    - `rows`, shape (m, n, segments.FIELDS): receives the segments; with n = 0 none are stored.
    - `row_count`, shape (m,): receives the number of stored segments of this phase.
    - Result: `COMPLETED` or `TOO_MANY_EVENTS`.
    """
    electrical = drive.pole_pairs * speed
    if electrical < _STANDSTILL:
        # At this speed the time of a radian would overflow.
        electrical = 0.0
    if reference < _LEAST_REFERENCE:
        # This current rises and falls within the rounding of time; the gates remain blocked, as at zero.
        reference = 0.0
    winding = _winding(drive)
    emf_peak = drive.emf_constant * speed
    angle = wrapped(angle)
    shape = shape_at(corners, corner_values, corner_slopes, angle, electrical)
    window = window_at(angle + advance, drive.window, electrical)
    sector = window.sector
    latch = latches[phase]
    gate_was = sectors[phase] * latch if reference > 0.0 else 0
    if sector != sectors[phase]:
        # The latch is set again at each window's start.
        latch = 1
    # A new command may have changed i* or the window, so evaluate both comparators again.
    if sector != 0:
        latch = _compared(latch, sector * currents[phase], reference, drive.hysteresis_band)
    motion = Motion(currents[phase], latch, 0, 0, 0)
    sums = no_sums(abs(motion.current))
    switching = 0.0
    time = 0.0
    events = 0

    while time < duration:
        events += 1
        if events > EVENT_LIMIT:
            return TOO_MANY_EVENTS
        value = shape.start + shape.rate * (time - shape.begin)
        limit = min(duration, shape.end, window.end)
        stretch = Stretch(
            phase, time, max(limit - time, 0.0), value, shape.rate, emf_peak * value, emf_peak * shape.rate
        )
        gate, slides, motion = _regulated(
            winding, drive, stretch, motion, window.sector, reference, upper, lower
        )
        if gate != gate_was:
            switching += _switching_energy(drive, gate_was, gate)
            gate_was = gate
        demand = Demand(reference, drive.hysteresis_band, window.sector, gate)
        if slides:
            length, is_whole, sums, motion = slide(winding, demand, stretch, upper, lower, sums, motion, rows)
        else:
            length, is_whole, sums, motion = not_sliding(
                winding, demand, stretch, upper, lower, sums, motion, rows
            )
        # Use the limit itself, not the sum, so that a corner is passed exactly once.
        time = limit if is_whole else time + length
        # `while`, because corners closer together than the rounding of time are passed together.
        while time >= shape.end:
            shape = next_shape(corners, corner_values, corner_slopes, shape, electrical)
        while time >= window.end:
            window = next_window(window, drive.window, electrical)
            latch = motion.latch
            if window.sector != 0:
                # A latch is on when its window opens, whatever it was in the preceding one.
                latch = _compared(1, window.sector * motion.current, reference, drive.hysteresis_band)
            motion = Motion(motion.current, latch, 0, motion.conducting, motion.kept)

    currents[phase] = motion.current
    sectors[phase] = window.sector
    latches[phase] = motion.latch
    row_count[phase] = motion.kept
    _add_to_ledger(totals, drive, emf_peak, sums, switching, events)
    return COMPLETED
