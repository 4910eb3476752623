"""How the designs try an advance angle: slew there, let the regulator settle, average the current sum.

A probe that costs regulation is taken back at once and counts as infinitely dear; nothing is probed below its
angle again until command, supply or load changes. A search only says which angle comes next.
"""

from __future__ import annotations

from math import inf
from typing import Any

from drivegate_models.angle_movement import (
    ABSORB,
    BEGIN,
    INTERVAL,
    MOST_RESTARTS,
    RETREAT,
    SMALLEST_CHANGE,
    WAIT,
    begin_interval,
    enter,
    rest_at_best,
    restart,
    slew,
)
from drivegate_models.angle_rest import rest
from drivegate_models.compilation import (
    unfused,
)
from drivegate_models.design_state import MEASURING, MOVING, PAUSING, RECHECKING, RECOVERING, SETTLING
from drivegate_models.regulation_guard import UNEASY
from drivegate_models.regulation_recovery import (
    check_load,
    creeps,
    is_overloaded,
    recover,
    take_back,
    winds_up,
)

_PAUSE = 0.07
_SETTLED = 0.01
_UNSTEADY = 0.02
_SAME_LOAD = 0.02
_LIGHT = 0.7
_COARSE = 6.0
_SMALLEST_POWER = 1.0


@unfused
def note_starting_angle(state: Any, power: float) -> None:
    """Note what the present load needs at the starting angle, and forget the search before.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With a complete interval.
    power : float
        Mean current sum of the interval (A).
    """
    if state.mode == RECHECKING:
        state.forbidden = -inf
        state.proven = state.home
        state.restarts = 0
        state.disturbances = 0
        state.age = 0
    integral = state.integral_sum / state.count
    state.doubtful = 0
    state.home_power = power
    state.home_ratio = integral / power
    state.home_error = state.worst_error
    state.grain = 1.0 if power > _LIGHT * state.current_limit else _COARSE
    state.good_offset = state.offset
    state.good_integral = integral
    state.best_offset = state.offset
    state.best_power = power
    state.finished = 0
    state.stage = 0
    state.probes = 0


@unfused
def settle(state: Any, power: float) -> int:
    """Wait at the starting angle until the current sum repeats.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With a complete interval.
    power : float
        Mean current sum of the interval (A).

    Returns
    -------
    int
        `WAIT`, `BEGIN`, or `ABSORB` where the load is the same and an interrupted search goes on.
    """
    change = abs(power - state.old_power)
    state.old_power = power
    regulated = state.worst_error <= UNEASY and state.saturated == 0
    if not regulated or power < _SMALLEST_POWER or change > _SETTLED * power + SMALLEST_CHANGE:
        return WAIT
    same_load = state.mode == RECHECKING and abs(power - state.home_power) <= _SAME_LOAD * power
    if same_load and state.pursuing == 1:
        state.pursuing = 0
        state.good_offset = state.offset
        state.good_integral = state.integral_sum / state.count
        state.old_power = inf
        return ABSORB
    if same_load:
        # The load is the same: it was a passing disturbance, or the rest was too near to the edge.
        state.disturbances += 1
        if state.disturbances > 1:
            state.forbidden = max(state.forbidden, state.disturbed_at)
            state.best_offset = max(state.best_offset, state.forbidden + RETREAT * state.grain)
        state.restarts = MOST_RESTARTS
        rest_at_best(state)
        return WAIT
    note_starting_angle(state, power)
    return BEGIN


@unfused
def measure(state: Any, power: float) -> int:
    """End a probe with the mean of its current sum.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With a complete interval.
    power : float
        Mean current sum of the interval (A).

    Returns
    -------
    int
        `WAIT` or `ABSORB`.
    """
    second_half = 2.0 * power - state.first_half
    if abs(second_half - state.first_half) > _UNSTEADY * power + SMALLEST_CHANGE:
        state.repeats += 1
        if state.repeats > 3:
            restart(state)
        begin_interval(state)
        return WAIT
    below = state.offset < state.good_offset
    if below and (
        state.worst_error > UNEASY
        or state.saturated > 0
        or creeps(state, state.good_integral, power, state.best_power)
        or (state.grain == 1.0 and winds_up(state, state.integral_sum / state.count, power))
    ):
        take_back(state)
        return WAIT
    if is_overloaded(state, power):
        # Perhaps the regulator still settles.
        state.repeats += 1
        if state.repeats > 3:
            check_load(state)
        begin_interval(state)
        return WAIT
    state.good_offset = state.offset
    state.good_integral = state.integral_sum / state.count
    state.proven = min(state.proven, state.offset)
    if power < state.best_power:
        state.best_power = power
        state.best_offset = state.offset
    state.old_power = power
    return ABSORB


@unfused
def finish_interval(state: Any) -> int:
    """Evaluate the running mean where it is complete.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    int
        `WAIT`, `BEGIN` or `ABSORB`.
    """
    length = max(round(INTERVAL / state.control_period), 2)
    if state.count == length // 2:
        state.first_half = state.power_sum / state.count
    if state.count < length:
        return WAIT
    power = state.power_sum / state.count
    work = WAIT
    mode = state.mode
    if mode in (SETTLING, RECHECKING):
        work = settle(state, power)
    elif mode == MEASURING:
        work = measure(state, power)
    else:
        rest(state, power)
    begin_interval(state)
    return work


@unfused
def probe_angle(state: Any, saturated: bool) -> int:
    """Do one control period of the present mode.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    saturated : bool
        Whether the current reference is at its limit.

    Returns
    -------
    int
        What the search has to do: `WAIT`, `BEGIN` or `ABSORB`.
    """
    state.age += 1
    reached = slew(state)
    elapsed = state.elapsed * state.control_period
    state.elapsed += 1
    if state.blind > 0 or (not reached and state.mode != MOVING):
        begin_interval(state)
        return WAIT
    if state.mode == MOVING:
        if reached:
            enter(state, PAUSING)
        return WAIT
    if state.mode == PAUSING:
        if elapsed >= _PAUSE:
            enter(state, MEASURING)
        return WAIT
    if state.mode == RECOVERING:
        return recover(state, saturated, elapsed)
    state.count += 1
    state.power_sum += state.current_sum
    state.integral_sum += state.integral
    state.worst_error = max(state.worst_error, abs(state.error))
    if saturated:
        state.saturated += 1
    return finish_interval(state)
