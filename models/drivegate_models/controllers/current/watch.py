"""The part of a decision that all searches for the advance angle share: observe, then wait or continue.

The reference and the correct controllers of other designs use it. They differ in the next angle.
"""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    CHANGED,
    TUNED_SUM,
    has_drifted,
    is_another_load,
    is_heavier_between,
    is_kept_by_another_load,
    is_repeated,
    load_has_changed,
    rearm_here,
    rearm_unless_repeated,
)
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.following import decide_following, tries_following
from drivegate_models.controllers.current.forbidden_angle import forbid, forget_load, is_heavier_load
from drivegate_models.controllers.current.modes import begin_settling, rearm
from drivegate_models.controllers.current.protection import back_off, back_off_farther, revert_step
from drivegate_models.controllers.current.state import (
    FOLLOWING,
    HOLDING,
    NOT_RETRIED,
    SEARCHING,
    SETTLING,
    SMALLEST_STEP,
    STEPPED_OFF,
)
from drivegate_models.controllers.current.unrest import (
    EXACT,
    current_sum_noise,
    is_jolted,
    is_regulator_responding,
    is_sag_lasting,
    is_speed_unsteady,
)
from drivegate_models.controllers.current.winding import (
    has_lost_torque,
    is_creeping,
    is_unwinding,
    is_wound_up,
    unwind,
    unwind_after_recovery,
    winds_up,
)

WAITING: Final = 0
"""Result of a decision: the search waits."""
BEGINNING: Final = 1
"""Result of a decision: the current sum repeats, so the search takes its first step."""
CONTINUING: Final = 2
"""Result of a decision: the search continues from its last step."""

_SETTLED = 0.01
# A load that is still rising may look settled once.
_SETTLED_INTERVALS = 2
# Intervals of a steady current sum after which the speed will not become steadier.
_SETTLED_UNEASY = 8
# Decisions after which a current sum that does not repeat is that of a load that varies. It takes up to twelve until
# it repeats after a loss of speed.
_LONGEST_SETTLING = 20
_SMALLEST_SHARE = 1.0 / TUNED_SUM
_RESTLESS = 0.003
# First steps beyond which the last step of a climb no longer indicates the distance to the edge.
_FAR_CLIMB = 4.0
# Steps that are long, in first steps.
_LONG = 1.5


@inlined
def decide_holding(state: Any, current_sum: float, change: float) -> None:
    """Monitor the angle found: search again after a change of load, and step off an edge that is too near.

    `current_sum` is the mean of the decision interval and `change` its change from the preceding interval (A).
    """
    unsteady = is_speed_unsteady(state)
    # While the speed recovers from the last step, the current sum is not yet the one at rest.
    if state.rest_power == inf and state.quiet > 0 and not unsteady:
        state.rest_power = current_sum
    # A load that changes slowly moves `held_power` with it, one step off the edge after another.
    changed = has_drifted(state, current_sum) or is_another_load(state, current_sum, state.held_power)
    if is_creeping(state, current_sum, 0.5 * CHANGED):
        state.integral = state.good_integral
        back_off(state, state.first_step if unsteady else 0.5 * SMALLEST_STEP, True)
    elif state.quiet <= 0:
        # The interval of the last step is not judged.
        state.quiet = 1
        if not changed:
            state.held_power = current_sum
    elif changed:
        rearm(state)
    elif is_kept_by_another_load(state, current_sum):
        rearm_here(state)
    elif is_sag_lasting(state) or (not unsteady and is_restless(state, current_sum, change)):
        # The optimum may lie on the edge itself: an angle slightly above it costs less than a new search.
        forbid(state)
        state.offset += SMALLEST_STEP
        state.quiet = STEPPED_OFF


@inlined
def is_restless(state: Any, current_sum: float, change: float) -> bool:
    """Return True if the current sum at rest differs from the last interval's and from the one when the rest began.

    Both differences (A) must exceed what regulator and sensors explain. Through coarse sensors the sum alternates
    from one interval to the next, which does not indicate the edge.
    """
    explained = _RESTLESS * current_sum + current_sum_noise(state)
    restless: bool = min(abs(change), abs(current_sum - state.held_power)) > explained
    return restless


@inlined
def is_speed_recovering(state: Any, current_sum: float, change: float) -> bool:
    """Return True if the current sum may mislead because the speed still recovers from a step.

    `change` is the change of the mean current sum by the step (A). A falling sum leads on in any case.
    """
    falling = change < -max(state.power_tolerance * current_sum, current_sum_noise(state))
    # Small steps do not disturb the speed; an unsteady speed after one of them indicates the edge.
    large = abs(state.moved) >= state.first_step
    return large and not falling and is_speed_unsteady(state)


@inlined
def is_current_too_small(state: Any) -> bool:
    """Return True if the last interval's mean current sum is too small to indicate anything about the angle."""
    return is_current_below(state, _SMALLEST_SHARE)


@inlined
def is_load_varying(state: Any) -> bool:
    """Return True if the current sum has not repeated for so long that the load varies."""
    varying: bool = state.unsettled > _LONGEST_SETTLING
    return varying


@inlined
def record_interval(state: Any, current_sum: float) -> None:
    """Record how steady the speed was in a decision interval, and whether the integral grew for no more current.

    `current_sum` is the mean of the interval (A).
    """
    # An encoder reading may be exact by chance, which does not measure its quantization.
    if state.worst_error > EXACT:
        state.calm_error = min(state.calm_error, state.worst_error)
    state.integral_growth = state.integral - state.last_integral
    state.winding = state.winding + 1 if winds_up(state, current_sum) else 0
    state.last_integral = state.integral
    state.last_power = current_sum


@inlined
def settle(state: Any, current_sum: float, change: float, settled: bool) -> int:
    """Return WAITING until current sum and speed have settled, then BEGINNING.

    `change` is the change of the mean current sum from the preceding interval (A); `settled` is True if they agree.
    """
    # The search would mistake a load that is still rising for the effect of its first step.
    state.quiet = state.quiet + 1 if settled else 0
    # Over two intervals a growth exceeds the noise that hides it over one.
    growth = current_sum - state.quiet_from
    state.quiet_from = current_sum - change
    if state.quiet >= _SETTLED_UNEASY:
        # The speed was steadier at other angles; at this one the regulator and the hysteresis band beat.
        state.calm_error = max(state.calm_error, state.worst_error)
    if state.quiet < _SETTLED_INTERVALS or is_wound_up(state, current_sum) or is_speed_unsteady(state):
        return WAITING
    explained = 2.0 * _RESTLESS * current_sum + current_sum_noise(state)
    if growth < -explained or (state.confirmed == 1 and growth > explained):
        # The load still falls, which looks like saving. Or the first steps saved little, and it still grows: slowly,
        # but by more than steps save.
        return WAITING
    if (
        (state.retried != NOT_RETRIED or is_unwinding(state))
        and state.quiet < _SETTLED_UNEASY
        and is_regulator_responding(state, current_sum)
    ):
        # After a loss of speed, what regains it would be taken for the cost of the first step, or for the load.
        return WAITING
    if is_creeping(state, current_sum, CHANGED):
        # The speed is steady, but the regulator wound up during recovery: the next step would start from too much
        # current reference.
        state.integral = state.good_integral
        back_off(state, SMALLEST_STEP, True)
        return WAITING
    state.quiet = 0
    state.mode = SEARCHING
    state.lost_speed = inf
    if state.offset == 0.0:
        state.initial_power = current_sum
    if abs(state.climb) > _FAR_CLIMB * state.first_step:
        # After a climb in growing steps, the angle is about as far from the edge as the initial angle usually is.
        state.step = state.first_step
    if state.grows == 0:
        # Not sooner: until the current sum has settled, the long step explains what it saved.
        state.step = min(state.step, state.first_step)
        # Short steps would take long to the optimum of a light load, which is far away.
        if tries_following(state, current_sum):
            return WAITING
    state.climb = 0.5 * state.first_step
    state.regained = -inf
    return BEGINNING


@inlined
def leaves_search(state: Any, load_changed: bool, jolted: bool) -> bool:
    """Settle or restart where the current sum or the speed shows another load, and return True; else return False."""
    if jolted and state.tries_again == 1 and abs(state.moved) > _LONG * state.first_step:
        # A long step may cost as much speed. Another load shows at this angle, from which shorter steps lead on.
        state.grows = 0
        begin_settling(state)
        return True
    return (load_changed or jolted) and rearm_unless_repeated(state)


@inlined
def rests(state: Any, current_sum: float, change: float) -> bool:
    """Monitor an operation that the search has led to, and return True; return False while it is still searching.

    `current_sum` is the mean of the decision interval and `change` its change from the preceding interval (A).
    """
    if state.mode == FOLLOWING:
        decide_following(state, current_sum, abs(change) <= _SETTLED * current_sum)
        return True
    if state.mode == HOLDING:
        decide_holding(state, current_sum, change)
        return True
    return False


@inlined
def watch_search(state: Any, fall: float, rise: float, jolt: float) -> tuple[int, float]:
    """Make the part of a decision that is the same for every search, at the end of an interval.

    `fall` and `rise` are the maximum changes of the current sum by one step of this search, as shares. `jolt` is its
    maximum loss of speed, as a share of k1. Anything more indicates another load. Return what the search does next
    (`WAITING`, `BEGINNING` or `CONTINUING`) and the change of the mean current sum from the preceding interval (A).
    """
    current_sum = state.power_sum / state.count
    state.unsettled = state.unsettled + 1 if state.mode == SETTLING else 0
    record_interval(state, current_sum)
    if is_heavier_load(state, current_sum) or is_load_varying(state):
        # This load lost the torque, not the angle with the previous load; or another one than the one to come did.
        forget_load(state)
    regulated = state.worst_error <= state.speed_tolerance and state.saturated == 0
    change = current_sum - state.old_power
    state.old_power = current_sum
    if rests(state, current_sum, change):
        return WAITING, change
    if state.mode == SETTLING and state.error > state.lost_speed:
        back_off_farther(state, state.error)
        return WAITING, change
    if unwind_after_recovery(state, current_sum):
        return WAITING, change
    if is_speed_unsteady(state) and unwind(state, current_sum):
        return WAITING, change
    # While the speed is off its reference, the current sum indicates nothing about the angle.
    if not regulated or is_current_too_small(state):
        begin_settling(state)
        return WAITING, change
    settled = abs(change) <= _SETTLED * current_sum
    # At the last good angle, the angle explains no more than it does while holding.
    back = abs(state.offset - state.good_offset) <= 0.5 * state.first_step and state.good_power < inf
    # To regain its speed, a heavy shaft needs more.
    steady = settled and not is_speed_unsteady(state)
    differs_there = steady and back and is_another_load(state, current_sum, state.good_power)
    heavier = steady and not is_wound_up(state, current_sum) and is_heavier_between(state, current_sum)
    if state.mode == SETTLING and (differs_there or heavier) and not is_repeated(state):
        rearm_here(state)
        return WAITING, change
    if has_lost_torque(state, current_sum, fall):
        state.integral = state.good_integral
        revert_step(state, 0.5 * state.first_step - state.moved)
        return WAITING, change
    # A current sum indicates another load only once it is settled, the speed is back and the regulator is not wound
    # up. After small steps over the edge and back it does not.
    conclusive = state.mode != SETTLING or (
        steady and state.quiet > 0 and not is_wound_up(state, current_sum) and state.retried == NOT_RETRIED
    )
    # A longer step toward the optimum saves more.
    longest_fall = fall * max(1.0, state.step / state.first_step)
    load_changed = conclusive and load_has_changed(state, current_sum, longest_fall, rise)
    if leaves_search(state, load_changed, is_jolted(state, jolt)):
        return WAITING, change
    if state.mode == SETTLING:
        return settle(state, current_sum, change, settled), change
    if state.waited == 0 and is_speed_recovering(state, current_sum, change):
        state.waited = 1
        state.old_power = current_sum - change
        return WAITING, change
    state.waited = 0
    return CONTINUING, change
