"""The on-line search for the advance angle of least input power (paper, Fig. 4), literal and guarded.

Input power is judged by the current sum, which is proportional to the power exchanged with the supply
("Optimal Efficiency Control").
"""

from __future__ import annotations

from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    LOAD_CHANGED,
    is_another_load,
    may_step_farther,
    rearm_unless_repeated,
)
from drivegate_models.controllers.current.forbidden_angle import MARGIN, forget_other_load
from drivegate_models.controllers.current.protection import begin_settling, take_step
from drivegate_models.controllers.current.retry import is_kept_from_much, may_retry, retry, takes_care
from drivegate_models.controllers.current.state import NOT_RETRIED, SMALLEST_STEP
from drivegate_models.controllers.current.unrest import JOLT, is_uneasy, noise_of_power
from drivegate_models.controllers.current.watch import BEGINNING, WAITING, begin_holding, watch_search

_IMPROVEMENTS = 3
_WORSE = 3
# Turns after which steps grow no more: where an effect comes late, growth would follow each turn, for ever.
_REVERSALS = 4
# Steps in a row that change less than noise. With care they are small ones, which take as many to tell a slope.
_FLAT_STEPS = 2
_FLAT_STEPS_WITH_CARE = 4
# First steps from which on a step does not grow any more.
_LONG_STEP = 2.0
_LONG_STEP_WITH_CARE = 0.3
# First steps from the initial angle within which a rest is confirmed.
_NEAR_THE_START = 6.0


@inlined
def decide_by_flowchart(state: Any, error: float) -> None:
    """Make one decision of Fig. 4, literally: gate by k1, stop by k2, reverse or go on.

    Parameters
    ----------
    error : float
        Speed reference minus speed at the decision (rad/s).
    """
    power = state.power_sum / state.count
    if abs(error) > state.speed_tolerance:
        return
    # The first one is minus infinity, as nothing came before, so the first step is always taken.
    change = power - state.old_power
    state.old_power = power
    if abs(change) <= state.power_tolerance * power:
        return
    if change > 0.0:
        state.direction = -state.direction
    state.offset += state.direction * state.step


@inlined
def rest_or_confirm(state: Any, power: float) -> None:
    """Rest where no step pays: at an edge in doubt after small steps, near the start after others like the first.

    A load that grows during the first steps takes as much current as they save, so that all of them look flat.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).
    """
    is_at_edge = state.offset - state.first_step < state.forbidden + MARGIN
    if is_at_edge and is_kept_from_much(state) and may_retry(state, True):
        retry(state, True)
        state.step = SMALLEST_STEP
        state.direction = -1.0
        state.improvements = 0
        state.quiet = 0
        take_step(state, power, -state.step)
        return
    if state.confirmed == 1 or is_at_edge or abs(state.offset) > _NEAR_THE_START * state.first_step:
        begin_holding(state, power)
        return
    state.confirmed = 1
    state.step = state.first_step
    state.direction = -1.0
    begin_settling(state)


@inlined
def may_widen(state: Any) -> bool:
    """Return whether the steps toward less angle have become small, and a whole one still fits.

    Returns
    -------
    bool
        Once for a load; never on the way to more angle, near a forbidden one, or where small steps look for the edge.
    """
    room: bool = state.offset - state.first_step >= state.forbidden + MARGIN
    small: bool = state.direction < 0.0 and state.step < state.first_step
    return room and small and state.retried == NOT_RETRIED and state.widened == 0


@inlined
def move(state: Any, power: float, change: float) -> None:
    """Take the next step, by as much as the forbidden angle leaves; rest where nothing is left.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    """
    forget_other_load(state, power)
    # Half a step may still fit between here and the forbidden angle.
    while (
        state.step >= SMALLEST_STEP
        and state.direction < 0.0
        and state.offset - state.step < state.forbidden + MARGIN
    ):
        state.step = 0.5 * state.step
    made_worse = change > 0.0 and state.moved != 0.0
    dear = is_kept_from_much(state)
    if state.step < SMALLEST_STEP and not made_worse and may_retry(state, dear):
        retry(state, dear)
        state.step = SMALLEST_STEP
        state.improvements = 0
    if state.step < SMALLEST_STEP:
        if made_worse:
            # The last step made things worse: it is taken back before the search rests.
            state.offset -= state.moved
        rest_or_confirm(state, power)
        return
    take_step(state, power, state.direction * state.step)


@inlined
def is_flat_end(state: Any, power: float, change: float, slack: float) -> bool:
    """Count a step that changed less than noise, and return whether the search ends with it.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change by the step (A).
    slack : float
        What noise makes of the current sum (A).

    Returns
    -------
    bool
        One flat step is not yet the optimum, nor are some that together save more than noise.
    """
    careful = takes_care(state)
    flat_steps = state.quiet + 1
    state.quiet = flat_steps
    enough: bool = flat_steps >= (_FLAT_STEPS_WITH_CARE if careful else _FLAT_STEPS)
    if enough and may_widen(state):
        # What small steps change is less than noise; a larger one shows whether anything is left.
        state.step = state.first_step
        state.widened = 1
        state.quiet = 0
    elif enough and power > state.quiet_from - slack:
        return True
    if flat_steps == 1 or not careful:
        state.quiet_from = power - change
    return False


@inlined
def decide_guarded(state: Any) -> None:
    """Make one decision of the guarded search: climb down by halving and growing steps.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated; its decision interval is complete.
    """
    work, change = watch_search(state, LOAD_CHANGED, LOAD_CHANGED, JOLT)
    if work == WAITING:
        return
    power = state.last_power
    if work == BEGINNING:
        state.worse_from = power
        state.worse = 0
        move(state, power, change)
        return
    if change <= 0.0:
        state.worse_from = power
        state.worse = 0
    else:
        state.worse += 1
    grown = state.worse >= _WORSE and is_another_load(state, power, state.worse_from) and not is_uneasy(state)
    # Whichever way the steps go, it gets worse, and no torque is being lost: it is the load that grows.
    if grown and rearm_unless_repeated(state):
        return
    # Less than noise makes of the sum is no slope.
    slack = max(state.power_tolerance * power, noise_of_power(state))
    if abs(change) <= slack:
        if is_flat_end(state, power, change, slack):
            rest_or_confirm(state, power)
            return
    else:
        state.quiet = 0
        state.improvements += 1
        if change > 0.0:
            state.direction = -state.direction
            state.reversals += 1
            # At its whole step the flowchart would go to and fro for ever.
            state.step = 0.5 * state.step
            state.improvements = 0
        # At light load the optimum is 40 degrees or more away, too far for steps of one.
        elif (
            state.improvements >= _IMPROVEMENTS
            and state.reversals < _REVERSALS
            and state.step < (_LONG_STEP_WITH_CARE if takes_care(state) else _LONG_STEP) * state.first_step
            and may_step_farther(state, power, change)
        ):
            state.step = 2.0 * state.step
            state.improvements = 0
    move(state, power, change)
