"""Periodic state of the half-bridge drive at fixed speed, advance angle and current reference, by half-wave shooting.

The latch of a phase is set at each window's start, so its whole state there is one number, the current. With
equal half-sources the next half cycle is the mirror image: a current x at a window's start is periodic when
the half cycle ends with -x. Phase j is phase 1 shifted by (j - 1) pi/m, and the torque repeats every pi/m.
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

# Secant steps before plain repetition takes over, and repetitions before a state counts as aperiodic.
_SECANTS = 12
_SETTLING = 40


@inlined
def torque_period(drive: Drive, electrical: float) -> float:
    """Return the period of the torque in a periodic state.

    Parameters
    ----------
    drive : Drive
        The drive's constants.
    electrical : float
        Electrical speed (rad/s).

    Returns
    -------
    float
        (s).
    """
    return pi / (drive.phases * electrical)


@inlined
def averaged_cycles(_drive: Drive) -> int:
    """Return the number of electrical cycles that a search averages where no periodic state exists."""
    return 32


@kernel
def least_conceivable(drive: Drive, torque: float) -> float:
    """Return a current reference below which the drive cannot give a torque.

    A phase whose current stays within i* + h gives at most ``k_e (i* + h)``.

    Parameters
    ----------
    drive : Drive
        The drive's constants.
    torque : float
        Mean electromagnetic torque (N m).

    Returns
    -------
    float
        Current reference (A), 0 or more.
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
    """Run one half cycle from a window's start with a current; keep the state at each phase shift.

    Returns minus the current at the end (A), which a periodic state repeats.
    """
    count = drive.phases
    shift = pi / count
    step = shift / (drive.pole_pairs * speed)
    # Where the window opens the latch is set, so that the current is the whole state.
    angle = 0.5 * (pi - drive.window) - advance
    corners = drive.emf_angles
    corner_values = drive.emf_values
    corner_slopes = drive.emf_slopes
    currents = work.currents
    sectors = work.sectors
    latches = work.latches
    rows = work.rows
    row_counts = work.row_counts
    # A literal would be compiled for by itself, beside the one for every phase.
    first = int(np.int64(0))
    currents[0] = start
    # As if from the gap before, so that the advance sets the latch anew.
    sectors[0] = 0
    latches[0] = 1
    # Cut at the phase shifts: there the first phase is in the state that another had half a cycle ago.
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
    """Find the periodic state and leave it, at the first phase's window start, in `work`.

    Parameters
    ----------
    drive : Drive
        The drive's constants.
    work, slices : Phases
        Room for the computation; `work` receives the state of all phases.
    speed : float
        Shaft speed (rad/s), above 0.
    voltage : float
        Voltage of each half-source (V).
    reference : float
        Current reference (A).
    advance : float
        Advance angle (rad electrical).

    Returns
    -------
    int
        `PERIODIC`, or `APERIODIC` with the state after `_SETTLING` half cycles.
    """
    scratch = np.zeros(ledger.ENTRIES)
    tolerance = TOLERANCE * (1.0 + reference)
    # Where the current dies out before the next window, zero is periodic at once.
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
            # With a band the map jumps where a chop enters or leaves the half cycle; no secant helps.
            following = image
            if attempt < _SECANTS and gap != last_gap:
                following = start - gap * (start - last_start) / (gap - last_gap)
                # Two gaps nearly alike send the secant far off; repetition stays in range.
                if abs(following) > 10.0 * (reference + 1.0):
                    following = image
            last_start = start
            last_gap = gap
            start = following
    # Phase j is now where phase 1 was pi - j pi/m later, half a cycle ago.
    count = drive.phases
    work.currents[0] = start
    work.sectors[0] = 0
    work.latches[0] = 1
    for k in range(1, count):
        work.currents[k] = -slices.currents[count - k]
        work.sectors[k] = -slices.sectors[count - k]
        work.latches[k] = slices.latches[count - k]
    return certified
