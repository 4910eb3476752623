"""The periodic state of the star at fixed speed, advance angle and current reference, by shooting.

If both half cycles are the same, phase j now equals minus phase j - (m - 1)/2 half an m-th of a cycle later. If only
the positive windows chop, it equals phase j + 1 an m-th of a cycle later. So a state is periodic if the advance over
that part of the cycle reproduces it with exchanged phases. The unknowns are m - 1 currents. The map is smooth as long
as no event appears or disappears, and Newton steps find its fixed point.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import called, inlined, kernel, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC, PERIODIC, TOLERANCE
from drivegate_models.star.plant.drive import EVERY_HALF, StarDrive
from drivegate_models.star.plant.phases import StarPhases, advance_phases
from drivegate_models.star.plant.window import GAP, PIECES

# Steps before plain repetition, and repetitions before a state counts as aperiodic.
_STEPS = 20
_SETTLING = 60
# Periods before the first step: currents that die out or reach their level no longer depend on their initial values.
_WARM_UP = 2
# A difference that is small compared with every current, and large compared with rounding.
_DIFFERENCE = 1e-6
# A step by old slopes is good enough if it reduces the gap to this share.
_GOOD = 0.1
# A step that leaves more than this share of the gap has failed.
_POOR = 0.5


class _Point(NamedTuple):
    speed: float
    voltage: float
    reference: float
    advance: float
    angle: float
    duration: float


class _Workspace(NamedTuple):
    """Work space for a search of n = m - 1 unknowns."""

    scratch: NDArray[np.float64]
    gap: NDArray[np.float64]
    """Difference of the state after a period from the state before it, shape (m,) (A)."""
    last_gap: NDArray[np.float64]
    step: NDArray[np.float64]
    image: NDArray[np.float64]
    weights: NDArray[np.float64]
    slopes: NDArray[np.float64]
    """Derivatives of the gap, shape (n, n)."""
    inverse: NDArray[np.float64]
    kept_currents: NDArray[np.float64]
    """An earlier state, to detect its recurrence, shape (m,) (A)."""
    kept_latches: NDArray[np.int64]


@inlined
def _is_symmetric(drive: StarDrive) -> bool:
    """Return True if positive and negative windows chop in the same way."""
    return drive.regulation & 3 == (drive.regulation >> 2) & (EVERY_HALF >> 2)


@inlined
def torque_period(drive: StarDrive, electrical: float) -> float:
    """Return the period of the torque in a periodic state (s), at an electrical speed (rad/s)."""
    return (pi if _is_symmetric(drive) else 2.0 * pi) / (drive.phases * electrical)


@inlined
def averaged_cycles(_drive: StarDrive) -> int:
    """Return the number of electrical cycles that a search averages if there is no periodic state.

    Means over this number differ from means over forty times as many by less than 1e-5 for half of these states, and by
    less than 1e-3 for 95 % of them.
    """
    return 8


@inlined
def least_conceivable(drive: StarDrive, torque: float) -> float:
    """Return a current reference below which the drive cannot produce a torque.

    `torque`: mean electromagnetic torque (N m). Result: current reference (A), 0 or more; 0 if a phase that does not
    chop may carry more than the reference.
    """
    if drive.regulation != EVERY_HALF:
        return 0.0
    return max(torque / (drive.phases * drive.emf_constant) - drive.hysteresis_band, 0.0)


@unallocating
def _gap(
    drive: StarDrive,
    work: StarPhases,
    slices: StarPhases,
    point: _Point,
    scratch: NDArray[np.float64],
    gap: NDArray[np.float64],
) -> float:
    """Advance from the state in `slices`, store its image in `work`, and return the maximum difference (A)."""
    count = drive.phases
    for k in range(count):
        work.currents[k] = slices.currents[k]
        work.pieces[k] = slices.pieces[k]
        work.latches[k] = slices.latches[k]
    advance_phases(
        drive,
        work,
        point.angle,
        point.speed,
        point.voltage,
        point.voltage,
        point.reference,
        point.advance,
        point.duration,
        scratch,
    )
    symmetric = _is_symmetric(drive)
    shift = (count + 1) // 2 if symmetric else 1
    # Exchange in place, with the magnitudes as work space, which the next advance clears.
    for k in range(count):
        work.magnitudes[k] = work.currents[(k + shift) % count]
        work.row_counts[k] = work.pieces[(k + shift) % count] * 2 + work.latches[(k + shift) % count]
    worst = 0.0
    for k in range(count):
        work.currents[k] = -work.magnitudes[k] if symmetric else work.magnitudes[k]
        piece = work.row_counts[k] // 2
        work.pieces[k] = (piece + PIECES // 2) % PIECES if symmetric else piece
        work.latches[k] = work.row_counts[k] % 2
        difference = work.currents[k] - slices.currents[k]
        gap[k] = difference
        worst = max(worst, abs(difference))
        # With a band the comparators are part of the state.
        if drive.hysteresis_band > 0.0 and work.latches[k] != slices.latches[k]:
            worst = np.inf
    return worst


@inlined
def _adopt(work: StarPhases, slices: StarPhases) -> None:
    """Use the state after a period as the next state."""
    for k in range(work.currents.size):
        slices.currents[k] = work.currents[k]
        slices.pieces[k] = work.pieces[k]
        slices.latches[k] = work.latches[k]


@inlined
def _keep(slices: StarPhases, workspace: _Workspace) -> None:
    """Store a state for `_is_kept`."""
    for k in range(slices.currents.size):
        workspace.kept_currents[k] = slices.currents[k]
        workspace.kept_latches[k] = slices.latches[k]


@inlined
def _is_kept(drive: StarDrive, slices: StarPhases, workspace: _Workspace, tolerance: float) -> bool:
    """Return True if a state equals the stored one, except for a tolerance (A)."""
    for k in range(slices.currents.size):
        if not abs(slices.currents[k] - workspace.kept_currents[k]) <= tolerance:
            return False
        if drive.hysteresis_band > 0.0 and slices.latches[k] != workspace.kept_latches[k]:
            return False
    return True


@inlined
def _shift_current(slices: StarPhases, phase: int, change: float) -> None:
    """Change one current (A), and the last one by the opposite amount."""
    slices.currents[phase] += change
    slices.currents[slices.currents.size - 1] -= change


@inlined
def _invert(matrix: NDArray[np.float64], inverse: NDArray[np.float64]) -> bool:
    """Invert a small matrix, which is overwritten, by elimination with pivots; return True if that was possible."""
    size = matrix.shape[0]
    for row in range(size):
        for column in range(size):
            inverse[row, column] = 1.0 if row == column else 0.0
    for column in range(size):
        pivot = column
        for row in range(column + 1, size):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        if not abs(matrix[pivot, column]) > 0.0:
            return False
        for k in range(size):
            matrix[column, k], matrix[pivot, k] = matrix[pivot, k], matrix[column, k]
            inverse[column, k], inverse[pivot, k] = inverse[pivot, k], inverse[column, k]
        per = 1.0 / matrix[column, column]
        for k in range(size):
            matrix[column, k] *= per
            inverse[column, k] *= per
        for row in range(size):
            if row != column:
                factor = matrix[row, column]
                for k in range(size):
                    matrix[row, k] -= factor * matrix[column, k]
                    inverse[row, k] -= factor * inverse[column, k]
    return True


@inlined
def _update_inverse(
    inverse: NDArray[np.float64],
    step: NDArray[np.float64],
    change: NDArray[np.float64],
    image: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> None:
    """Update the inverse slopes by a step and the resulting change of the gap (Broyden's update)."""
    size = step.size
    divisor = 0.0
    for row in range(size):
        image[row] = 0.0
        weights[row] = 0.0
        for column in range(size):
            image[row] += inverse[row, column] * change[column]
            weights[row] += step[column] * inverse[column, row]
        divisor += step[row] * image[row]
    if divisor == 0.0:
        return
    for row in range(size):
        share = (step[row] - image[row]) / divisor
        for column in range(size):
            inverse[row, column] += share * weights[column]


@unallocating
def _differentiate(
    drive: StarDrive, work: StarPhases, slices: StarPhases, point: _Point, workspace: _Workspace
) -> bool:
    """Compute the slopes of the gap by differences, and their inverse; return True if there is one."""
    gap = workspace.gap
    last_gap = workspace.last_gap
    unknowns = gap.size - 1
    change = _DIFFERENCE * (1.0 + point.reference)
    for k in range(gap.size):
        last_gap[k] = gap[k]
    for column in range(unknowns):
        _shift_current(slices, column, change)
        _gap(drive, work, slices, point, workspace.scratch, gap)
        _shift_current(slices, column, -change)
        for row in range(unknowns):
            workspace.slopes[row, column] = (gap[row] - last_gap[row]) / change
    for k in range(gap.size):
        gap[k] = last_gap[k]
    return _invert(workspace.slopes, workspace.inverse)


@inlined
def _is_out_of_range(step: NDArray[np.float64], limit: float) -> bool:
    """Return True if a step leads to currents beyond a limit that the drive cannot exceed (A)."""
    size = 0.0
    for k in range(step.size):
        size = max(size, abs(step[k]))
    return not size <= limit


@unallocating
def _newton_step(
    drive: StarDrive,
    work: StarPhases,
    slices: StarPhases,
    point: _Point,
    workspace: _Workspace,
    is_known: bool,
    before: float,
) -> tuple[bool, float]:
    """Take a step toward the periodic state; return True if its slopes are still valid, and the gap (A)."""
    gap = workspace.gap
    last_gap = workspace.last_gap
    step = workspace.step
    inverse = workspace.inverse
    if not is_known:
        is_known = _differentiate(drive, work, slices, point, workspace)
    for row in range(step.size):
        step[row] = 0.0
        for column in range(step.size):
            step[row] -= inverse[row, column] * gap[column]
    if not is_known or _is_out_of_range(step, 10.0 * (point.reference + drive.current_limit)):
        # A period leads closer, although slowly. The differences have overwritten `work`, so repeat it first.
        _gap(drive, work, slices, point, workspace.scratch, gap)
        _adopt(work, slices)
        return False, _gap(drive, work, slices, point, workspace.scratch, gap)
    for k in range(step.size):
        last_gap[k] = gap[k]
        _shift_current(slices, k, step[k])
    worst = _gap(drive, work, slices, point, workspace.scratch, gap)
    if worst <= _GOOD * before:
        for k in range(step.size):
            last_gap[k] = gap[k] - last_gap[k]
        _update_inverse(inverse, step, last_gap, workspace.image, workspace.weights)
        return True, worst
    if not worst < before:
        # The slopes next to a corner of the map may be useless.
        _adopt(work, slices)
        worst = _gap(drive, work, slices, point, workspace.scratch, gap)
    return False, worst


@called
@kernel
def periodic_start(
    drive: StarDrive,
    work: StarPhases,
    slices: StarPhases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> int:
    """Find the periodic state, and store it at the first phase's window start in `work`.

    With a band, a state often repeats only after a few torque periods. During plain repetition, each state is compared
    with a stored one, which is replaced each time that twice as many periods have passed (Brent's algorithm).

    - `work`, `slices`: work space; `work` receives the state of all phases.
    - `speed`: shaft speed (rad/s), above 0.
    - `voltage`: half of the link's voltage (V).
    - `reference`: current reference i* (A).
    - `advance`: advance angle (rad electrical).
    - Result: number of torque periods after which the state repeats, `PERIODIC` for one; or `APERIODIC` with the state
      after `_SETTLING` periods or more.
    """
    count = drive.phases
    unknowns = count - 1
    workspace = _Workspace(
        np.zeros(ledger.ENTRIES),
        np.zeros(count),
        np.zeros(count),
        np.zeros(unknowns),
        np.zeros(unknowns),
        np.zeros(unknowns),
        np.zeros((unknowns, unknowns)),
        np.zeros((unknowns, unknowns)),
        np.zeros(count),
        np.zeros(count, np.int64),
    )
    duration = torque_period(drive, drive.pole_pairs * speed)
    point = _Point(speed, voltage, reference, advance, 0.5 * (pi - drive.window) - advance, duration)
    tolerance = TOLERANCE * (1.0 + reference)
    for k in range(count):
        slices.currents[k] = 0.0
        slices.pieces[k] = GAP
        slices.latches[k] = 1
    worst = _gap(drive, work, slices, point, workspace.scratch, workspace.gap)
    is_known = False
    waiting = _WARM_UP
    failures = 0
    periods = APERIODIC
    age = 0
    oldest = 0
    for attempt in range(_STEPS + _SETTLING):
        if worst <= tolerance:
            break
        if waiting == 0 and attempt < _STEPS:
            before = worst
            is_known, worst = _newton_step(drive, work, slices, point, workspace, is_known, worst)
            if worst > _POOR * before:
                # Near corners of the map these steps may repeat in a circle without end; plain periods lead out of it.
                failures += 1
                waiting = _WARM_UP * failures
        else:
            _adopt(work, slices)
            if attempt >= _STEPS:
                age += 1
                if oldest > 0 and _is_kept(drive, slices, workspace, tolerance):
                    periods = age
                    break
                if age >= oldest:
                    _keep(slices, workspace)
                    oldest = max(2 * oldest, 1)
                    age = 0
            worst = _gap(drive, work, slices, point, workspace.scratch, workspace.gap)
            waiting = max(waiting - 1, 0)
            is_known = False
    for k in range(count):
        work.currents[k] = slices.currents[k]
        work.pieces[k] = slices.pieces[k]
        work.latches[k] = slices.latches[k]
    return PERIODIC if worst <= tolerance else periods
