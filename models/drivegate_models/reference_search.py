"""The current reference at which the drive's steady state gives a wanted mean torque.

Torque is not monotone in the current reference (unregulated current past the window's middle turns against
the machine), and with a hysteresis band it jumps wherever a chop enters or leaves the window. So the
reference is scanned upward, the first bracket taken, and a jump across the wanted torque reported as the
share of time on each side.
"""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import NamedTuple

import numpy as np

from drivegate_models import ledger
from drivegate_models.compilation import kernel
from drivegate_models.drive import Drive
from drivegate_models.plant import Phases, advance_phases
from drivegate_models.steady_state import AVERAGED_CYCLES, PERIODIC, periodic_start

OUT_OF_REACH: int = 0
"""No current reference up to the limit gives the torque."""
STATIC: int = 1
"""A smaller current reference gives the torque, but the current limit itself does not."""
ROBUST: int = 2
"""The torque at the current limit reaches the wanted torque, so a saturated regulator recovers."""
CURRENT_TOLERANCE: float = 1e-9
"""Width to which a current reference is located (A)."""

_SCAN_STEPS = 100
_GOLDEN = 0.5 * (sqrt(5.0) - 1.0)


class MeanState(NamedTuple):
    """Steady-state means that the searches compare."""

    torque: float
    """Mean electromagnetic torque (N m)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    input_power: float
    """Net power taken from the supply, core loss and switching included (W)."""


class ReferenceSearch(NamedTuple):
    """Current reference, or pair of references in time shares, that gives a wanted mean torque."""

    feasibility: int
    """`ROBUST`, `STATIC` or `OUT_OF_REACH`."""
    low: float
    """Reference on the side of less torque (A); NaN out of reach."""
    high: float
    """Reference on the side of more torque (A), equal to `low` where the torque is continuous."""
    share: float
    """Share of time at `high`, 0 to 1, at which the mean torque is the wanted one."""


@kernel
def mean_state(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> MeanState:
    """Return the means of one steady state without its extremes, faster than the whole solution.

    Parameters
    ----------
    drive : Drive
        The drive's constants.
    work, slices : Phases
        Room for the computation; neither needs room for segments.
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
    MeanState
        As `drivegate_models.steady_state.solve_steady_state` has them.
    """
    certified = periodic_start(drive, work, slices, speed, voltage, reference, advance)
    angle = 0.5 * (pi - drive.window) - advance
    electrical = drive.pole_pairs * speed
    totals = np.zeros(ledger.ENTRIES)
    # A periodic torque repeats every pi/m; an aperiodic state is averaged over whole cycles.
    length = pi / (drive.phases * electrical)
    count = 1
    if certified != PERIODIC:
        length = 2.0 * pi / electrical
        count = AVERAGED_CYCLES
    for _ in range(count):
        advance_phases(drive, work, angle, speed, voltage, voltage, reference, advance, length, totals)
    per = 1.0 / (count * length)
    power = totals[ledger.UPPER] + totals[ledger.LOWER]
    power += totals[ledger.CORE_SOURCE] + totals[ledger.SWITCHING]
    return MeanState(totals[ledger.IMPULSE] * per, totals[ledger.MAGNITUDE] * per, power * per)


@kernel
def _mean_torque(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> float:
    return mean_state(drive, work, slices, speed, voltage, reference, advance).torque


@kernel
def greatest_torque(
    drive: Drive, work: Phases, slices: Phases, speed: float, voltage: float, advance: float, limit: float
) -> tuple[float, float]:
    """Return the greatest mean torque over all current references up to a limit.

    Parameters
    ----------
    drive, work, slices, speed, voltage, advance
        As in `mean_state`.
    limit : float
        Greatest current reference (A).

    Returns
    -------
    torque : float
        Greatest mean torque (N m), on a grid of a hundredth of the limit and by golden section about the best.
    reference : float
        Where it is (A).
    """
    step = limit / _SCAN_STEPS
    best = limit
    most = _mean_torque(drive, work, slices, speed, voltage, limit, advance)
    for k in range(_SCAN_STEPS):
        torque = _mean_torque(drive, work, slices, speed, voltage, k * step, advance)
        if torque > most:
            most = torque
            best = k * step
    low = max(best - step, 0.0)
    high = min(best + step, limit)
    while high - low > 1e-6 * limit:
        left = high - _GOLDEN * (high - low)
        right = low + _GOLDEN * (high - low)
        left_torque = _mean_torque(drive, work, slices, speed, voltage, left, advance)
        right_torque = _mean_torque(drive, work, slices, speed, voltage, right, advance)
        if left_torque > most:
            most = left_torque
            best = left
        if right_torque > most:
            most = right_torque
            best = right
        if left_torque >= right_torque:
            high = right
        else:
            low = left
    return most, best


@kernel
def _located(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    advance: float,
    torque: float,
    feasibility: int,
    low: float,
    low_gap: float,
    high: float,
    high_gap: float,
    tolerance: float,
) -> ReferenceSearch:
    """Shrink a bracket of the wanted torque (gap < 0 at `low`, >= 0 at `high`) by safeguarded regula falsi."""
    near = drive.phases * drive.emf_constant * tolerance
    low_weight = low_gap
    high_weight = high_gap
    side = 0
    turn = 0
    while high - low > tolerance and high_gap > near and low_gap < -near:
        turn += 1
        middle = 0.5 * (low + high)
        # Every third step halves the bracket: across a jump the false position alone would creep.
        if turn % 3 != 0:
            secant = low - low_weight * (high - low) / (high_weight - low_weight)
            if low < secant < high:
                middle = secant
        if not low < middle < high:
            break
        gap = _mean_torque(drive, work, slices, speed, voltage, middle, advance) - torque
        if gap >= 0.0:
            high = middle
            high_gap = gap
            high_weight = gap
            if side == 1:
                low_weight *= 0.5
            side = 1
        else:
            low = middle
            low_gap = gap
            low_weight = gap
            if side == -1:
                high_weight *= 0.5
            side = -1
    if high_gap <= near:
        return ReferenceSearch(feasibility, high, high, 0.0)
    if low_gap >= -near:
        return ReferenceSearch(feasibility, low, low, 0.0)
    return ReferenceSearch(feasibility, low, high, low_gap / (low_gap - high_gap))


@kernel
def reference_for_torque(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    advance: float,
    torque: float,
    limit: float,
    tolerance: float,
) -> ReferenceSearch:
    """Return the least current reference at which the mean torque is the wanted one.

    The reference is scanned upward in steps of a hundredth of the limit, so a torque that is reached only
    within a narrower stretch of references is found only where it surrounds the greatest torque.

    Parameters
    ----------
    drive, work, slices, speed, voltage, advance
        As in `mean_state`.
    torque : float
        Wanted mean electromagnetic torque (N m).
    limit : float
        Greatest current reference (A).
    tolerance : float
        Width to which the reference is located (A), `CURRENT_TOLERANCE` unless speed matters more.

    Returns
    -------
    ReferenceSearch
        One reference, or two with the share of time at the higher torque where it jumps across the wanted one.
    """
    at_limit = _mean_torque(drive, work, slices, speed, voltage, limit, advance) - torque
    feasibility = ROBUST if at_limit >= 0.0 else STATIC
    # No phase gives more than k_e (i* + h) while its current is regulated, so the scan can start there.
    low = max(torque / (drive.phases * drive.emf_constant) - drive.hysteresis_band, 0.0)
    if low >= limit:
        low = 0.0
    low_gap = _mean_torque(drive, work, slices, speed, voltage, low, advance) - torque
    if low_gap >= 0.0 and low > 0.0:
        low = 0.0
        low_gap = _mean_torque(drive, work, slices, speed, voltage, low, advance) - torque
    if low_gap >= 0.0:
        # Gates blocked; a braking torque beyond what rectification gives cannot be asked for.
        if low_gap <= drive.phases * drive.emf_constant * CURRENT_TOLERANCE:
            return ReferenceSearch(feasibility, 0.0, 0.0, 0.0)
        return ReferenceSearch(OUT_OF_REACH, nan, nan, nan)
    step = limit / _SCAN_STEPS
    while low < limit:
        high = min(low + step, limit)
        high_gap = at_limit
        if high < limit:
            high_gap = _mean_torque(drive, work, slices, speed, voltage, high, advance) - torque
        if high_gap >= 0.0:
            return _located(
                drive,
                work,
                slices,
                speed,
                voltage,
                advance,
                torque,
                feasibility,
                low,
                low_gap,
                high,
                high_gap,
                tolerance,
            )
        low = high
        low_gap = high_gap
    most, best = greatest_torque(drive, work, slices, speed, voltage, advance, limit)
    if most < torque:
        return ReferenceSearch(OUT_OF_REACH, nan, nan, nan)
    low = max(best - step, 0.0)
    low_gap = _mean_torque(drive, work, slices, speed, voltage, low, advance) - torque
    return _located(
        drive,
        work,
        slices,
        speed,
        voltage,
        advance,
        torque,
        feasibility,
        low,
        low_gap,
        best,
        most - torque,
        tolerance,
    )
