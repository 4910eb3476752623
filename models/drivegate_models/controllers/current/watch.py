"""What a search for the advance angle does at each decision, whatever search it is: it watches, and waits or goes on.

The reference and the correct controllers of other designs share it; they differ in where the angle goes next.
"""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    CHANGED,
    TUNED_SUM,
    has_moved_on,
    is_another_load,
    load_has_changed,
    rearm_unless_repeated,
)
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.forbidden_angle import allow_all_angles, forbid, is_heavier_load
from drivegate_models.controllers.current.protection import (
    begin_settling,
    give_step_back,
    rearm,
    walk_back,
    walk_farther_back,
)
from drivegate_models.controllers.current.state import (
    HOLDING,
    NOT_RETRIED,
    SEARCHING,
    SETTLING,
    SMALLEST_STEP,
    STEPPED_OFF,
)
from drivegate_models.controllers.current.unrest import (
    EXACT,
    is_answering,
    is_jolted,
    is_sagging,
    is_uneasy,
    noise_of_power,
)
from drivegate_models.controllers.current.winding import (
    has_cost_torque,
    is_creeping,
    is_wound,
    unwind,
    unwind_when_back,
    winds_up,
)

WAITING: Final = 0
"""What the search has to do: nothing."""
BEGINNING: Final = 1
"""What the search has to do: take its first step since the current sum repeats."""
CONTINUING: Final = 2
"""What the search has to do: go on from its last step."""

_SETTLED = 0.01
# A load that is still coming on may look settled once.
_SETTLED_INTERVALS = 2
# Intervals of a steady current sum after which the speed will not get any calmer.
_SETTLED_UNEASY = 8
# Intervals of a current sum that only grows slowly after which it is not waited for any more.
_SETTLED_GROWING = 20
_SMALLEST_POWER = 1.0 / TUNED_SUM
_RESTLESS = 0.003
# First steps beyond which the last step of a climb says nothing of the edge any more.
_FAR_CLIMB = 4.0


@inlined
def begin_holding(state: Any, power: float) -> None:
    """Rest at the angle found.

    Parameters
    ----------
    power : float
        Current sum found there (A).
    """
    state.mode = HOLDING
    state.held_power = power
    state.rest_power = inf
    # Without a step before it, the angle held is the only good one known.
    if state.good_power == inf:
        state.good_offset = state.offset
        state.good_integral = state.integral
        state.good_power = power
    state.moved = 0.0
    state.quiet = 0


@inlined
def decide_holding(state: Any, power: float, change: float) -> None:
    """Watch what was found: search anew after a change of load, and keep off an edge that is too near.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    """
    uneasy = is_uneasy(state)
    # While the speed comes back from the last step, the current sum is not yet that of the rest.
    if state.rest_power == inf and state.quiet > 0 and not uneasy:
        state.rest_power = power
    # A load that comes or goes slowly moves `held_power` along, step off the edge by step.
    changed = has_moved_on(state, power) or is_another_load(state, power, state.held_power)
    if is_creeping(state, power, 0.5 * CHANGED):
        state.integral = state.good_integral
        walk_back(state, state.first_step if uneasy else 0.5 * SMALLEST_STEP, True)
    elif state.quiet <= 0:
        # The interval of its own last step is not judged.
        state.quiet = 1
        if not changed:
            state.held_power = power
    elif changed:
        rearm(state)
    elif is_sagging(state) or (not uneasy and is_restless(state, power, change)):
        # The optimum may lie on the edge itself: a little above it costs less than a new search.
        forbid(state)
        state.offset += SMALLEST_STEP
        state.quiet = STEPPED_OFF


@inlined
def is_restless(state: Any, power: float, change: float) -> bool:
    """Return whether the current sum has left where it was an interval ago, and where it was when the rest began.

    Through coarse sensors it goes to and fro from one interval to the next; that is no sign of the edge.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, at rest.
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).

    Returns
    -------
    bool
        By more than regulator and sensors explain.
    """
    explained = _RESTLESS * power + noise_of_power(state)
    restless: bool = min(abs(change), abs(power - state.held_power)) > explained
    return restless


@inlined
def is_read_too_soon(state: Any, power: float, change: float) -> bool:
    """Return whether the current sum may mislead, since the speed still comes back from a step.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change by the step (A).

    Returns
    -------
    bool
        False where the sum falls anyway, which leads on.
    """
    falling = change < -max(state.power_tolerance * power, noise_of_power(state))
    # Small steps do not disturb the speed; after one of them unrest is a sign of the edge.
    large = abs(state.moved) >= state.first_step
    return large and not falling and is_uneasy(state)


@inlined
def is_unloaded(state: Any) -> bool:
    """Return whether so little current has flown in the last decision interval that it says nothing of the angle.

    Returns
    -------
    bool
        About its mean current sum.
    """
    return draws_less_than(state, _SMALLEST_POWER)


@inlined
def remember(state: Any, power: float) -> None:
    """Keep of a decision interval how calm the speed was, and whether the integral grew for no more current.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).
    """
    # An encoder may show a speed as exact by chance, which is no measure of its steps.
    if state.worst_error > EXACT:
        state.calm_error = min(state.calm_error, state.worst_error)
    state.winding = state.winding + 1 if winds_up(state, power) else 0
    state.last_integral = state.integral
    state.last_power = power


@inlined
def settle(state: Any, power: float, change: float, settled: bool) -> int:
    """Wait until current sum and speed have settled, and begin to search then.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    settled : bool
        Whether it is that of the interval before.

    Returns
    -------
    int
        `WAITING` or `BEGINNING`.
    """
    # A load that is still coming on would be taken for the effect of the first step.
    state.quiet = state.quiet + 1 if settled else 0
    if state.quiet >= _SETTLED_UNEASY:
        # It has been calmer at other angles; at this one regulator and band beat.
        state.calm_error = max(state.calm_error, state.worst_error)
    if state.quiet < _SETTLED_INTERVALS or is_wound(state, power) or is_uneasy(state):
        return WAITING
    growing = change > _RESTLESS * power + noise_of_power(state)
    if state.confirmed == 1 and state.quiet < _SETTLED_GROWING and growing:
        # The first steps looked flat, and the load still grows: slowly, yet by more than steps save.
        return WAITING
    if state.retried != NOT_RETRIED and state.quiet < _SETTLED_UNEASY and is_answering(state, power):
        # Small steps follow a loss of speed; the rest of the way back would be taken for what the first one costs.
        return WAITING
    if is_creeping(state, power, CHANGED):
        # Calm, but wound up on the way back: the next step would be one from too much current reference.
        state.integral = state.good_integral
        walk_back(state, SMALLEST_STEP, True)
        return WAITING
    state.quiet = 0
    state.mode = SEARCHING
    state.lost_speed = inf
    if state.offset == 0.0:
        state.initial_power = power
    if abs(state.climb) > _FAR_CLIMB * state.first_step:
        # Climbed in growing steps, the angle is as far from the edge as the initial angle mostly is.
        state.step = state.first_step
    state.climb = 0.5 * state.first_step
    state.regained = -inf
    return BEGINNING


@inlined
def watch_search(state: Any, fall: float, rise: float, jolt: float) -> tuple[int, float]:
    """Make the part of a decision that is the same for every search.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated; its decision interval is complete, its mean current sum becomes `last_power`.
    fall, rise : float
        Changes of the current sum that one step of this search explains, as shares; more is another load.
    jolt : float
        Speed that one step of this search costs at most, as a share of k1; more is another load.

    Returns
    -------
    work : int
        `WAITING`, `BEGINNING` or `CONTINUING`: what is left to the search itself.
    change : float
        Change of the mean current sum from the interval before (A).
    """
    power = state.power_sum / state.count
    remember(state, power)
    if is_heavier_load(state, power):
        # It was this load that lost the torque, not the angle with the load of before.
        allow_all_angles(state)
    regulated = state.worst_error <= state.speed_tolerance and state.saturated == 0
    change = power - state.old_power
    state.old_power = power
    if state.mode == HOLDING:
        decide_holding(state, power, change)
        return WAITING, change
    if state.mode == SETTLING and state.error > state.lost_speed:
        walk_farther_back(state, state.error)
        return WAITING, change
    if unwind_when_back(state):
        return WAITING, change
    if is_uneasy(state) and unwind(state, power):
        return WAITING, change
    # A current sum with the speed off its reference says nothing about the angle.
    if not regulated or is_unloaded(state):
        begin_settling(state)
        return WAITING, change
    settled = abs(change) <= _SETTLED * power
    # Back at the last good angle, the angle explains no more than while one is held.
    back = abs(state.offset - state.good_offset) <= 0.5 * state.first_step and state.good_power < inf
    if state.mode == SETTLING and settled and back and is_another_load(state, power, state.good_power):
        rearm(state)
        return WAITING, change
    if has_cost_torque(state, power, fall):
        state.integral = state.good_integral
        give_step_back(state, 0.5 * state.first_step - state.moved)
        return WAITING, change
    # Nor does one that still changes, with the speed still on its way back or the regulator still wound up, or after
    # small steps over the edge and the way up from there, tell of another load.
    told = state.mode != SETTLING or (
        settled
        and state.quiet > 0
        and not is_uneasy(state)
        and not is_wound(state, power)
        and state.retried == NOT_RETRIED
    )
    seems = told and load_has_changed(state, power, fall, rise)
    if (seems or is_jolted(state, jolt)) and rearm_unless_repeated(state):
        return WAITING, change
    if state.mode == SETTLING:
        return settle(state, power, change, settled), change
    if state.waited == 0 and is_read_too_soon(state, power, change):
        state.waited = 1
        state.old_power = power - change
        return WAITING, change
    state.waited = 0
    return CONTINUING, change
