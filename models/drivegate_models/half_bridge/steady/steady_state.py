"""Periodic steady state at fixed speed, advance angle and current reference, by half-wave shooting.

The latch of a phase is set at each window's start, so its whole state there is one number, the current. With
equal half-sources the next half cycle is the mirror image: a current x at a window's start is periodic when
the half cycle ends with -x. Phase j is phase 1 shifted by (j - 1) pi/m, and the torque repeats every pi/m.
With a hysteresis band a periodic state need not exist; then means over `AVERAGED_CYCLES` cycles are returned
and the state is marked so.
"""

from __future__ import annotations

from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import kernel, unallocating
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phase import COMPLETED, advance_phase
from drivegate_models.half_bridge.plant.phases import Phases, advance_phases, make_phases
from drivegate_models.machine import ledger
from drivegate_models.machine.torque import torque_extremes

PERIODIC: int = 1
"""Certified: the half cycle returns its own mirror image."""
APERIODIC: int = 0
"""No periodic state was found; the values are means over `AVERAGED_CYCLES` electrical cycles."""
AVERAGED_CYCLES: int = 32
"""Electrical cycles that are averaged where no periodic state exists."""
TOLERANCE: float = 1e-10
"""Greatest change of the current over a half cycle that is certified as periodic (A)."""
KEPT_TIME: float = 1e-3
"""Longest piece of a torque period whose segments are kept at once (s)."""

# Secant steps before plain repetition takes over, and repetitions before a state counts as aperiodic.
_SECANTS = 12
_SETTLING = 40


class SteadyState(NamedTuple):
    """Means over the steady state at one point."""

    certified: int
    """`PERIODIC` or `APERIODIC`."""
    torque: float
    """Mean electromagnetic torque (N m)."""
    torque_lowest: float
    """Least torque (N m)."""
    torque_highest: float
    """Greatest torque (N m)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    exchanged_power: float
    """Power exchanged with the half-sources (W)."""
    returned_power: float
    """The part of it that flows back (W)."""
    source_power: float
    """Net power that windings and devices take from the supply (W)."""
    copper_loss: float
    """(W)."""
    device_loss: float
    """Forward drops and switching (W)."""
    core_loss: float
    """Core loss, from the supply and from the shaft (W)."""
    core_source_power: float
    """The part of the core loss that the supply delivers directly (W)."""
    core_drag: float
    """Drag torque of the core loss of floating phases (N m)."""
    current_peak: float
    """Greatest phase current (A)."""
    switching_loss: float
    """Turn-on and turn-off losses (W), also part of `device_loss`."""


@kernel
def _summarised(
    drive: Drive,
    certified: int,
    speed: float,
    duration: float,
    totals: NDArray[np.float64],
    lowest: float,
    highest: float,
) -> SteadyState:
    per = 1.0 / duration
    drag = totals[ledger.CORE_DRAG_IMPULSE] * per
    core_source = totals[ledger.CORE_SOURCE] * per
    switching = totals[ledger.SWITCHING] * per
    return SteadyState(
        certified,
        totals[ledger.IMPULSE] * per,
        lowest,
        highest,
        totals[ledger.MAGNITUDE] * per,
        totals[ledger.EXCHANGED] * per,
        totals[ledger.RETURNED] * per,
        (totals[ledger.UPPER] + totals[ledger.LOWER]) * per,
        drive.resistance * totals[ledger.SQUARE] * per,
        totals[ledger.DEVICE] * per + switching,
        core_source + drag * speed,
        core_source,
        drag,
        totals[ledger.PEAK],
        switching,
    )


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
def advance_with_extremes(
    drive: Drive,
    phases: Phases,
    angle: float,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
    duration: float,
    totals: NDArray[np.float64],
) -> tuple[int, float, float]:
    """Advance all phases in pieces short enough to keep their segments, and return the torque's range.

    Parameters
    ----------
    drive, phases, angle, speed, reference, advance, duration, totals
        As in `drivegate_models.half_bridge.plant.phases.advance_phases`; `phases` has room for `KEPT_TIME`.
    voltage : float
        Voltage of each half-source (V).

    Returns
    -------
    status : int
        Status of the advance.
    lowest, highest : float
        Extremes of the torque (N m).
    """
    lowest = inf
    highest = -inf
    positions = np.zeros(drive.phases, np.int64)
    # At low speed a torque period outlasts the room for segments.
    pieces = int(duration / KEPT_TIME) + 1
    length = duration / pieces
    status = COMPLETED
    turn = drive.pole_pairs * speed * length
    for piece in range(pieces):
        status = max(
            status,
            advance_phases(
                drive,
                phases,
                angle + piece * turn,
                speed,
                voltage,
                voltage,
                reference,
                advance,
                length,
                totals,
            ),
        )
        lowest, highest = torque_extremes(
            phases.rows,
            phases.row_counts,
            positions,
            drive.emf_constant,
            drive.resistance / drive.inductance,
            length,
            lowest,
            highest,
        )
    return status, lowest, highest


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


@kernel
def solve_steady_state(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> SteadyState:
    """Return the steady state at one point.

    Parameters
    ----------
    drive, work, slices, speed, voltage, reference, advance
        As in `periodic_start`; `work` has room for segments of `KEPT_TIME`.

    Returns
    -------
    SteadyState
        Means, and the torque's exact extremes.
    """
    certified = periodic_start(drive, work, slices, speed, voltage, reference, advance)
    angle = 0.5 * (pi - drive.window) - advance
    totals = np.zeros(ledger.ENTRIES)
    electrical = drive.pole_pairs * speed
    if certified == PERIODIC:
        # All phases are alike, so everything repeats with the shift; a cycle would cost 2 m times as much.
        duration = pi / (drive.phases * electrical)
        _, lowest, highest = advance_with_extremes(
            drive, work, angle, speed, voltage, reference, advance, duration, totals
        )
        return _summarised(drive, certified, speed, duration, totals, lowest, highest)
    cycle = 2.0 * pi / electrical
    lowest = 0.0
    highest = 0.0
    for k in range(AVERAGED_CYCLES):
        _, low, high = advance_with_extremes(
            drive, work, angle, speed, voltage, reference, advance, cycle, totals
        )
        # Without a period the widest cycle stands for the ripple.
        if k == 0 or high - low > highest - lowest:
            lowest = low
            highest = high
    return _summarised(drive, certified, speed, AVERAGED_CYCLES * cycle, totals, lowest, highest)


@kernel
def cycles_from_rest(
    drive: Drive,
    work: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
    cycles: int,
) -> SteadyState:
    """Run electrical cycles from angle 0 with no current and latches on; return means over the last.

    Parameters
    ----------
    drive, work, speed, voltage, reference, advance
        As in `periodic_start`; `work` is fresh from `make_phases`.
    cycles : int
        Number of cycles, at least 1.

    Returns
    -------
    SteadyState
        Marked `APERIODIC`, since nothing is certified.
    """
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    totals = np.zeros(ledger.ENTRIES)
    lowest = 0.0
    highest = 0.0
    for _ in range(cycles):
        totals[:] = 0.0
        _, lowest, highest = advance_with_extremes(
            drive, work, 0.0, speed, voltage, reference, advance, cycle, totals
        )
    return _summarised(drive, APERIODIC, speed, cycle, totals, lowest, highest)


def steady_state(
    drive: Drive, speed: float, reference: float, advance: float, voltage: float | None = None
) -> SteadyState:
    """Return the steady state at one point, with room of its own.

    Parameters
    ----------
    drive : Drive
        The drive.
    speed : float
        Shaft speed (rad/s), above 0.
    reference : float
        Current reference (A).
    advance : float
        Advance angle (rad electrical).
    voltage : float, optional
        Voltage of each half-source (V); the drive's nominal one by default.

    Returns
    -------
    SteadyState
        Means, and the torque's exact extremes.
    """
    work = make_phases(drive, KEPT_TIME)
    slices = make_phases(drive)
    supply = drive.half_supply_voltage if voltage is None else voltage
    return solve_steady_state(drive, work, slices, speed, supply, reference, advance)
