"""Periodic state of the half-bridge drive at fixed speed, advance angle and current reference, by half-wave shooting.

The latch of a phase is set at each window's start, so its whole state there is one number, the current. With equal
half-sources the next half cycle is the mirror image: a current x at a window's start is periodic if the half cycle ends
with -x. Phase j is phase 1 shifted by (j - 1) pi/m, and the torque repeats every pi/m.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, kernel, unallocating
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phase import advance_phase
from drivegate_models.half_bridge.plant.phases import Phases
from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC, PERIODIC, TOLERANCE

# Secant steps before plain repetition, and repetitions before a state counts as aperiodic.
_SECANTS = 12
_SETTLING = 40


@inlined
def torque_period(drive: Drive, electrical: float) -> float:
    """Return the period of the torque in a periodic state (s), at an electrical speed (rad/s)."""
    return pi / (drive.phases * electrical)


@inlined
def averaged_cycles(_drive: Drive) -> int:
    """Return the number of electrical cycles that a search averages if there is no periodic state."""
    return 32


@kernel
def least_conceivable(drive: Drive, torque: float) -> float:
    """Return a current reference below which the drive cannot produce a torque.

    A phase whose current is at most i* + h produces at most ``k_e (i* + h)``.

    `torque`: mean electromagnetic torque (N m).
    """
    return max(torque / (drive.phases * drive.emf_constant) - drive.hysteresis_band, 0.0)


@unallocating
def _half_cycle(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
    start: float,
    scratch: NDArray[np.float64],
) -> float:
    """Run one half cycle from a window's start and current (A), and store the state at each phase shift.

    Return minus the current at the end (A), which equals the initial current in a periodic state.
    """
    count = drive.phases
    shift = pi / count
    step = shift / (drive.pole_pairs * speed)
    # The latch is set where the window opens, so the current is the whole state.
    angle = 0.5 * (pi - drive.window) - advance
    corners = drive.emf_angles
    corner_values = drive.emf_values
    corner_slopes = drive.emf_slopes
    currents = work.currents
    sectors = work.sectors
    latches = work.latches
    rows = work.rows
    row_counts = work.row_counts
    # A literal would cause a second compilation, in addition to the one for every phase.
    first = int(np.int64(0))
    currents[0] = start
    # Start from the preceding gap, so that the advance sets the latch.
    sectors[0] = 0
    latches[0] = 1
    # Stop at the phase shifts: there the first phase has the state that another phase had half a cycle ago.
    for k in range(count):
        slices.currents[k] = currents[0]
        slices.sectors[k] = sectors[0]
        slices.latches[k] = latches[0]
        advance_phase(
            drive,
            corners,
            corner_values,
            corner_slopes,
            first,
            currents,
            sectors,
            latches,
            angle + k * shift,
            speed,
            voltage,
            voltage,
            reference,
            advance,
            step,
            scratch,
            rows,
            row_counts,
        )
    return -float(currents[0])


@kernel
def periodic_start(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> int:
    """Find the periodic state, and store it at the first phase's window start in `work`.

    - `work`, `slices`: work space; `work` receives the state of all phases.
    - `speed`: shaft speed (rad/s), above 0.
    - `voltage`: voltage of each half-source (V).
    - `reference`: current reference i* (A).
    - `advance`: advance angle (rad electrical).
    - Result: `PERIODIC`, or `APERIODIC` with the state after `_SETTLING` half cycles.
    """
    scratch = np.zeros(ledger.ENTRIES)
    tolerance = TOLERANCE * (1.0 + reference)
    # If the current dies out before the next window, zero is periodic at once.
    start = 0.0
    image = _half_cycle(drive, work, slices, speed, voltage, reference, advance, start, scratch)
    certified = APERIODIC
    if abs(image - start) <= tolerance:
        certified = PERIODIC
    else:
        last_start = start
        last_gap = image - start
        start = image
        for attempt in range(_SECANTS + _SETTLING):
            image = _half_cycle(drive, work, slices, speed, voltage, reference, advance, start, scratch)
            gap = image - start
            if abs(gap) <= tolerance:
                certified = PERIODIC
                break
            # With a band the map jumps where a chop enters or leaves the half cycle, and secants do not help.
            following = image
            if attempt < _SECANTS and gap != last_gap:
                following = start - gap * (start - last_start) / (gap - last_gap)
                # Two nearly equal gaps send the secant far away; repetition remains in range.
                if abs(following) > 10.0 * (reference + 1.0):
                    following = image
            last_start = start
            last_gap = gap
            start = following
    # Phase j now has the state of phase 1 at pi - j pi/m after the start, half a cycle ago.
    count = drive.phases
    work.currents[0] = start
    work.sectors[0] = 0
    work.latches[0] = 1
    for k in range(1, count):
        work.currents[k] = -slices.currents[count - k]
        work.sectors[k] = -slices.sectors[count - k]
        work.latches[k] = slices.latches[count - k]
    return certified
