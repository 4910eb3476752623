"""The on-line search for the advance angle of least input power (paper, Fig. 4), literal and guarded.

Input power is judged by the current sum, which is proportional to the power exchanged with the supply
("Optimal Efficiency Control").
"""

from __future__ import annotations

from math import inf
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    CHANGED,
    LOAD_CHANGED,
    is_another_load,
    may_step_farther,
    rearm_unless_repeated,
)
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.following import goes_on
from drivegate_models.controllers.current.forbidden_angle import (
    LIGHT,
    first_direction,
    forget_other_load,
    lowest_offset,
)
from drivegate_models.controllers.current.modes import begin_settling, hold_angle
from drivegate_models.controllers.current.protection import take_step
from drivegate_models.controllers.current.retry import (
    is_edge_distance_costly,
    may_retry,
    needs_small_steps,
    retry,
)
from drivegate_models.controllers.current.state import NOT_PROBED, NOT_RETRIED, PROBED, PROBING, SMALLEST_STEP
from drivegate_models.controllers.current.unrest import JOLT, current_sum_noise, is_speed_unsteady
from drivegate_models.controllers.current.watch import BEGINNING, WAITING, watch_search

_IMPROVEMENTS = 3
_WORSE = 3
# Reversals after which steps no longer grow. If the effect of a step is delayed, growth would follow each reversal
# without end.
_REVERSALS = 4
# Consecutive steps that change less than noise. Small steps need more of them to show a slope.
_FLAT_STEPS = 2
_FLAT_STEPS_SMALL = 4
# Length of a probe, in first steps. Where the hysteresis band allows few pulses in a half-wave, the current sum is
# flat over some degrees before it falls again.
_PROBE = 5.0
# Current reference over the mean current of a conducting phase, up to which the EMF does not limit the current.
_FOLLOWS = 1.1
# Length at which a step no longer grows, in first steps.
_LONG_STEP = 2.0
_LONG_STEP_SMALL = 0.3


@inlined
def decide_by_flowchart(state: Any, error: float) -> None:
    """Make one decision of Fig. 4 without additions: gate by k1, stop by k2, reverse or continue.

    `error` is speed reference minus speed at the decision (rad/s).
    """
    current_sum = state.power_sum / state.count
    if abs(error) > state.speed_tolerance:
        return
    # The first change is minus infinity, so the first step is always taken.
    change = current_sum - state.old_power
    state.old_power = current_sum
    if abs(change) <= state.power_tolerance * current_sum:
        return
    if change > 0.0:
        state.direction = -state.direction
    state.offset += state.direction * state.step


@inlined
def may_probe(state: Any, current_sum: float) -> bool:
    """Return True if a long step toward less angle may show a lower current sum, and is not likely to lose the torque.

    Once where the search would rest. A current that follows its reference is far from the edge. `current_sum` is the
    mean of the interval (A).
    """
    is_far = state.forbidden == -inf and state.offset - _PROBE * state.first_step >= lowest_offset(state)
    follows = state.integral * state.conducting_phases <= _FOLLOWS * current_sum
    matters = not is_current_below(state, LIGHT)
    return bool(is_far and follows and matters and state.probe == NOT_PROBED and state.offset < 0.0)


@inlined
def rest_or_confirm(state: Any, current_sum: float) -> None:
    """Rest where no step saves current, after retrying at a doubtful edge and confirming what saved little.

    A load that grows meanwhile adds as much current as steps save, so all of them look flat. A search that saved
    little therefore confirms its result with new steps like the first. `current_sum` is the mean of the interval (A).
    """
    if may_probe(state, current_sum):
        state.probe = PROBING
        take_step(state, current_sum, -_PROBE * state.first_step)
        return
    if goes_on(state, current_sum):
        return
    at_edge = state.offset - state.first_step < lowest_offset(state)
    if at_edge and is_edge_distance_costly(state) and may_retry(state, True):
        retry(state, True)
        state.step = SMALLEST_STEP
        state.direction = -1.0
        state.improvements = 0
        state.quiet = 0
        take_step(state, current_sum, -state.step)
        return
    saved = state.initial_power - current_sum
    in_vain = state.offset < 0.0 and saved < 0.0 < state.initial_power
    if state.confirmed == 1 or saved > CHANGED * current_sum or (at_edge and not in_vain):
        hold_angle(state, current_sum)
        return
    state.confirmed = 1
    state.step = state.first_step
    state.direction = first_direction(state)
    if in_vain:
        # Less angle than the initial one has saved nothing, so the optimum may lie above it.
        state.offset = 0.0
        state.direction = 1.0
    begin_settling(state)


@inlined
def may_widen(state: Any) -> bool:
    """Return True if the steps toward less angle have become small, and a whole one still fits.

    Once per load. False on the way to more angle, near a forbidden angle, and while small steps look for the edge.
    """
    is_free: bool = state.offset - state.first_step >= lowest_offset(state)
    small: bool = state.direction < 0.0 and state.step < state.first_step
    return is_free and small and state.retried == NOT_RETRIED and state.widened == 0


@inlined
def move(state: Any, current_sum: float, change: float) -> None:
    """Take the next step, as far as the forbidden angle allows; rest if no step remains.

    `change` is the change of the mean current sum from the preceding interval (A).
    """
    forget_other_load(state, current_sum)
    # Half a step may still fit between here and the forbidden angle.
    while (
        state.step >= SMALLEST_STEP
        and state.direction < 0.0
        and state.offset - state.step < lowest_offset(state)
    ):
        state.step = 0.5 * state.step
    has_risen = change > 0.0 and state.moved != 0.0
    costly = is_edge_distance_costly(state)
    if state.step < SMALLEST_STEP and not has_risen and may_retry(state, costly):
        retry(state, costly)
        state.step = SMALLEST_STEP
        state.improvements = 0
    if state.step < SMALLEST_STEP:
        if has_risen:
            # The last step increased the current sum: revert it before the search settles.
            state.offset -= state.moved
        rest_or_confirm(state, current_sum)
        return
    take_step(state, current_sum, state.direction * state.step)


@inlined
def decide_probe(state: Any, current_sum: float, change: float, noise: float) -> None:
    """Go on from the probe if it has found less current; else return to the angle before it, and rest there.

    `current_sum` is the mean of the interval, `change` its change by the probe and `noise` its noise (A).
    """
    if current_sum < state.good_power - noise:
        state.probe = NOT_PROBED
        state.step = state.first_step
        state.direction = -1.0
        state.improvements = 0
        state.quiet = 0
        move(state, current_sum, change)
        return
    state.probe = PROBED
    state.offset = state.good_offset
    rest_or_confirm(state, state.good_power)


@inlined
def is_flat_end(state: Any, current_sum: float, change: float, noise: float) -> bool:
    """Count a step that changed less than noise, and return True if the search ends with it.

    `change` is the change of the mean current sum by the step and `noise` the noise of the sum (A). One flat step
    is not yet the optimum, nor are several that together save more than noise.
    """
    small_steps = needs_small_steps(state)
    flat_steps = state.quiet + 1
    state.quiet = flat_steps
    enough: bool = flat_steps >= (_FLAT_STEPS_SMALL if small_steps else _FLAT_STEPS)
    if enough and may_widen(state):
        # Small steps change less than noise; a larger one shows whether anything is left to save.
        state.step = state.first_step
        state.widened = 1
        state.quiet = 0
    elif enough and current_sum > state.quiet_from - noise:
        return True
    if flat_steps == 1 or not small_steps:
        state.quiet_from = current_sum - change
    return False


@inlined
def decide_guarded(state: Any) -> None:
    """Make one decision of the guarded search, at the end of an interval: descend by halving and growing steps."""
    action, change = watch_search(state, LOAD_CHANGED, LOAD_CHANGED, JOLT)
    if action == WAITING:
        return
    current_sum = state.last_power
    if action == BEGINNING:
        state.worse_from = current_sum
        state.worse = 0
        if state.direction < 0.0:
            state.direction = first_direction(state)
        move(state, current_sum, change)
        return
    if change <= 0.0:
        state.worse_from = current_sum
        state.worse = 0
    else:
        state.worse += 1
    grown = (
        state.worse >= _WORSE
        and is_another_load(state, current_sum, state.worse_from)
        and not is_speed_unsteady(state)
    )
    # Steps in both directions increase the current sum without losing torque: the load is growing.
    if grown and rearm_unless_repeated(state):
        return
    # A change within the noise of the current sum is not a slope.
    noise = max(state.power_tolerance * current_sum, current_sum_noise(state))
    if state.probe == PROBING:
        decide_probe(state, current_sum, change, noise)
        return
    if abs(change) <= noise:
        if is_flat_end(state, current_sum, change, noise):
            rest_or_confirm(state, current_sum)
            return
    else:
        state.quiet = 0
        state.improvements += 1
        if change > 0.0:
            state.direction = -state.direction
            state.reversals += 1
            # With whole steps, as in the flowchart, the angle would oscillate without end.
            state.step = 0.5 * state.step
            state.improvements = 0
        # At light load the optimum is 40 degrees or more away, too far for steps of one.
        elif (
            state.improvements >= _IMPROVEMENTS
            and state.reversals < _REVERSALS
            and state.grows == 1
            and state.step < (_LONG_STEP_SMALL if needs_small_steps(state) else _LONG_STEP) * state.first_step
            and may_step_farther(state, current_sum, change)
        ):
            state.step = 2.0 * state.step
            state.improvements = 0
    move(state, current_sum, change)
