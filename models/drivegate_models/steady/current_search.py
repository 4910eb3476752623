"""The current reference at which the drive's steady state produces a demanded mean torque.

Torque is not monotone in the current reference, because unregulated current after the window's middle brakes the
machine. With a hysteresis band it jumps wherever a chop enters or leaves the window. Therefore the reference is scanned
upward, the first bracket is used, and a jump across the demanded torque is reported as the share of time on each side.
"""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import NamedTuple

import numpy as np

from drivegate_models.compilation.kernels import called, kernel
from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC
from drivegate_models.steady.plant import (
    AnyDrive,
    AnyPhases,
    advance_phases,
    averaged_cycles,
    least_conceivable,
    periodic_start,
    torque_period,
)

OUT_OF_REACH: int = 0
"""No current reference up to the limit produces the torque."""
STATIC: int = 1
"""A smaller current reference produces the torque, but the current limit itself does not."""
ROBUST: int = 2
"""The torque at the current limit reaches the demanded torque, so a saturated regulator recovers."""
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
    """Net power from the supply, including core loss and switching (W)."""


class ReferenceSearch(NamedTuple):
    """Current reference, or pair of references with shares of time, that produces a demanded mean torque.

    Every number is NaN if the torque is out of reach.
    """

    feasibility: int
    """`ROBUST`, `STATIC` or `OUT_OF_REACH`."""
    low: float
    """Reference on the side of less torque (A)."""
    high: float
    """Reference on the side of more torque (A), equal to `low` if the torque is continuous."""
    share: float
    """Share of time at `high`, 0 to 1, for the demanded mean torque."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    input_power: float
    """Net power from the supply, including core loss and switching (W)."""


@called
@kernel
def mean_state(
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> MeanState:
    """Return the means of one steady state without its extremes, faster than the complete solution.

    - `speed`: shaft speed (rad/s), above 0.
    - `voltage`: voltage of each half-source (V).
    - `reference`: current reference i* (A).
    - `advance`: advance angle (rad electrical).
    - Result: the means of `drivegate_models.steady.steady_state.solve_steady_state`. If there is no periodic state,
      they are over the number of cycles returned by `averaged_cycles`.
    """
    periods = periodic_start(drive, work, slices, speed, voltage, reference, advance)
    angle = 0.5 * (pi - drive.window) - advance
    electrical = drive.pole_pairs * speed
    totals = np.zeros(ledger.ENTRIES)
    # A periodic torque repeats every pi/m, or after a few times that; an aperiodic state is averaged over whole cycles.
    length = periods * torque_period(drive, electrical)
    count = 1
    if periods == APERIODIC:
        length = 2.0 * pi / electrical
        count = averaged_cycles(drive)
    for _ in range(count):
        advance_phases(drive, work, angle, speed, voltage, voltage, reference, advance, length, totals)
    per = 1.0 / (count * length)
    power = totals[ledger.UPPER] + totals[ledger.LOWER]
    power += totals[ledger.CORE_SOURCE] + totals[ledger.SWITCHING]
    return MeanState(totals[ledger.IMPULSE] * per, totals[ledger.MAGNITUDE] * per, power * per)


@kernel
def greatest_torque(
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    speed: float,
    voltage: float,
    advance: float,
    limit: float,
    floor: float = 0.0,
) -> tuple[float, float]:
    """Return the maximum mean torque over all current references up to a limit.

    `drive`, `work`, `slices`, `speed`, `voltage`, `advance`: arguments of `mean_state`. `limit`: maximum current
    reference (A). `floor`: minimum current reference (A). Returns `torque`: maximum mean torque (N m), on a grid of a
    hundredth of the limit and then by golden section; `reference`: current reference of the maximum (A).
    """
    step = limit / _SCAN_STEPS
    # The most likely reference: torque falls only if more current outlasts the useful part of its half cycle.
    best = limit
    most = mean_state(drive, work, slices, speed, voltage, limit, advance).torque
    for k in range(int(max(floor, 0.0) / step), _SCAN_STEPS):
        torque = mean_state(drive, work, slices, speed, voltage, k * step, advance).torque
        if torque > most:
            most = torque
            best = k * step
    low = max(best - step, 0.0)
    high = min(best + step, limit)
    while high - low > 1e-6 * limit:
        left = high - _GOLDEN * (high - low)
        right = low + _GOLDEN * (high - low)
        left_torque = mean_state(drive, work, slices, speed, voltage, left, advance).torque
        right_torque = mean_state(drive, work, slices, speed, voltage, right, advance).torque
        # With a band the maximum is jagged, so use the best point found, not the last bracket.
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
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    speed: float,
    voltage: float,
    advance: float,
    torque: float,
    low: float,
    low_state: MeanState,
    high: float,
    high_state: MeanState,
    tolerance: float,
) -> ReferenceSearch:
    """Return the reference in a bracket, below the demanded torque at `low` and not at `high`.

    The bracket shrinks by regula falsi and halving to `tolerance` (A).
    """
    # The maximum torque of a current equal to the tolerance; a closer match does not improve the reference.
    near = drive.phases * drive.emf_constant * tolerance
    low_weight = low_state.torque - torque
    high_weight = high_state.torque - torque
    side = 0
    turn = 0
    while high - low > tolerance and high_state.torque > torque + near and low_state.torque < torque - near:
        turn += 1
        middle = 0.5 * (low + high)
        # Every third step halves the bracket: across a jump the false position alone would creep.
        if turn % 3 != 0:
            secant = low - low_weight * (high - low) / (high_weight - low_weight)
            if low < secant < high:
                middle = secant
        if not low < middle < high:
            break
        state = mean_state(drive, work, slices, speed, voltage, middle, advance)
        if state.torque >= torque:
            high = middle
            high_state = state
            high_weight = state.torque - torque
            # The Illinois rule: halve the weight of an end that does not move, or the false position would creep.
            if side == 1:
                low_weight *= 0.5
            side = 1
        else:
            low = middle
            low_state = state
            low_weight = state.torque - torque
            if side == -1:
                high_weight *= 0.5
            side = -1
    share = (torque - low_state.torque) / (high_state.torque - low_state.torque)
    # The remaining bracket of a coarse search is interpolated like a jump, without loss of precision.
    near = drive.phases * drive.emf_constant * CURRENT_TOLERANCE
    if high_state.torque <= torque + near:
        low = high
        low_state = high_state
        share = 0.0
    elif low_state.torque >= torque - near:
        high = low
        high_state = low_state
        share = 0.0
    return ReferenceSearch(
        ROBUST,
        low,
        high,
        share,
        low_state.current_sum + share * (high_state.current_sum - low_state.current_sum),
        low_state.input_power + share * (high_state.input_power - low_state.input_power),
    )


@kernel
def reference_for_torque(
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    speed: float,
    voltage: float,
    advance: float,
    torque: float,
    limit: float,
    tolerance: float,
    floor: float,
    robust_only: bool,
) -> ReferenceSearch:
    """Return the minimum current reference at which the mean torque is the demanded one.

    The reference is scanned upward in steps of a hundredth of the limit. A torque that is reached only in a narrower
    range of references is found only if this range contains the maximum torque.

    - `drive`, `work`, `slices`, `speed`, `voltage`, `advance`: arguments of `mean_state`.
    - `torque`: demanded mean electromagnetic torque (N m).
    - `limit`: maximum current reference (A).
    - `tolerance`: width to which the reference is located (A).
    - `floor`: initial reference if the result is known to be larger (A); 0 to scan all references.
    - `robust_only`: true to stop at once if the torque at the limit does not reach the demanded one.
    - Result: one reference; two with their shares of time if the torque jumps across the demanded one.
    """
    nowhere = ReferenceSearch(OUT_OF_REACH, nan, nan, nan, nan, nan)
    # Compute this first: it determines robust feasibility, and so ends the search at many angles.
    at_limit = mean_state(drive, work, slices, speed, voltage, limit, advance)
    feasibility = ROBUST if at_limit.torque >= torque else STATIC
    if robust_only and feasibility != ROBUST:
        return nowhere
    least = least_conceivable(drive, torque)
    low = 0.0
    low_state = at_limit
    # Use a lower start if the torque at this one already exceeds the demanded one.
    for start in (max(floor, least), least, 0.0):
        low = start if start < limit else 0.0
        low_state = mean_state(drive, work, slices, speed, voltage, low, advance)
        if low_state.torque < torque:
            break
    if low_state.torque >= torque:
        # With blocked gates, no more braking is possible than by rectification.
        if low_state.torque > torque + drive.phases * drive.emf_constant * CURRENT_TOLERANCE:
            return nowhere
        return ReferenceSearch(feasibility, 0.0, 0.0, 0.0, low_state.current_sum, low_state.input_power)
    step = limit / _SCAN_STEPS
    high = low
    high_state = low_state
    # Scan upward, so that the first bracket contains the minimum reference, although torque may not grow with it.
    while high < limit and high_state.torque < torque:
        low = high
        low_state = high_state
        high = min(low + step, limit)
        high_state = at_limit
        if high < limit:
            high_state = mean_state(drive, work, slices, speed, voltage, high, advance)
    if high_state.torque < torque:
        # The maximum is between two steps of the scan: its lower side contains the minimum reference.
        _, high = greatest_torque(drive, work, slices, speed, voltage, advance, limit, least)
        high_state = mean_state(drive, work, slices, speed, voltage, high, advance)
        if high_state.torque < torque:
            return nowhere
        low = max(high - step, 0.0)
        low_state = mean_state(drive, work, slices, speed, voltage, low, advance)
    found = _located(
        drive, work, slices, speed, voltage, advance, torque, low, low_state, high, high_state, tolerance
    )
    return ReferenceSearch(
        feasibility, found.low, found.high, found.share, found.current_sum, found.input_power
    )
