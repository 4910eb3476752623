"""Rules that distinguish another load from the effect of a search's own steps on the current sum."""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import maximum_current_sum
from drivegate_models.controllers.current.modes import rearm
from drivegate_models.controllers.current.protection import ALARM
from drivegate_models.controllers.current.state import NOT_RETRIED
from drivegate_models.controllers.current.unrest import JOLT, disturbed_speed_error

LOAD_CHANGED: Final = 0.12
"""Share of the current sum beyond which a search with one-degree steps attributes a difference to another load."""
CHANGED: Final = 0.03
"""Share of the current sum beyond which a difference at the same angle is another load."""
TUNED_SUM: Final = 104.0
"""Maximum current sum of the drive that currents are tuned on (A); tuned currents are shares of it."""
NEAR: Final = 3.0
"""Distance, in first steps, beyond which the angle alone may explain a difference between current sums."""
EITHER_WAY_NEAR: Final = 0.2 / TUNED_SUM
"""Share of the maximum current sum by which current sums of near angles differ in any case."""

# Shares of the current sum where the search came to rest: steps off the edge cost a little, and save nothing.
_LESS = 0.01
_MORE = 0.02
_EITHER_WAY = 0.4 / TUNED_SUM
_EITHER_WAY_STEADY = 0.3 / TUNED_SUM
# Restarts after which a change of load is taken for one seen before, wherever that was.
_MOST_RESTARTS = 3


@inlined
def differs(state: Any, current_sum: float, known: float, share: float, either_way: float) -> bool:
    """Return True if two current sums differ by more than `share` of the first plus `either_way` of the maximum.

    The sums are in A.
    """
    differ: bool = abs(current_sum - known) > share * current_sum + either_way * maximum_current_sum(state)
    return differ


@inlined
def is_another_load(state: Any, current_sum: float, known: float) -> bool:
    """Return True if two mean current sums at the same angle (A) differ by more than they do under a steady load."""
    return differs(state, current_sum, known, CHANGED, _EITHER_WAY_STEADY)


@inlined
def has_drifted(state: Any, current_sum: float) -> bool:
    """Return True if the mean current sum (A) has left the one at which the search came to rest, however slowly.

    False while nothing has been read at rest.
    """
    share = _LESS if current_sum < state.rest_power else _MORE
    return state.rest_power < inf and differs(state, current_sum, state.rest_power, share, _EITHER_WAY)


@inlined
def is_lighter_load(state: Any, current_sum: float) -> bool:
    """Return True if the return from the edge ended at less current (A) than a smaller angle needed before.

    False while no good angle is known, and below it.
    """
    above = state.offset >= state.good_offset
    lighter: bool = above and state.good_power < inf and current_sum < (1.0 - LOAD_CHANGED) * state.good_power
    return lighter


@inlined
def load_has_changed(state: Any, current_sum: float, fall: float, rise: float) -> bool:
    """Return True if the mean current sum (A) differs from the one of the last good angle by more than angles explain.

    `fall` and `rise` are the maximum effects of steps toward less and toward more angle, as shares of the current
    sum. False while no good angle is known, and away from it.
    """
    near = abs(state.offset - state.good_offset) <= NEAR * state.first_step
    share = fall if current_sum < state.good_power else rise
    changed: bool = near and differs(state, current_sum, state.good_power, share, EITHER_WAY_NEAR)
    return changed and state.good_power < inf


@inlined
def is_heavier_between(state: Any, current_sum: float) -> bool:
    """Return True if a mean current sum (A) between the initial and the last good angle exceeds what both needed.

    The load has grown while a step was taken, which then may not be what has lost the speed. False while either of the
    two is unknown.
    """
    between = state.good_offset < state.offset <= 0.0 < state.initial_power and state.good_power < inf
    needed = max(state.initial_power, state.good_power)
    heavier: bool = between and current_sum > needed and is_another_load(state, current_sum, needed)
    return heavier


@inlined
def is_kept_by_another_load(state: Any, current_sum: float) -> bool:
    """Return True if a search during which the load seemed to change has saved little, beside a doubtful angle.

    A step to that angle has cost speed that the load may have cost, or this load needs more current than the one then.
    Not without end. `current_sum` is the mean at rest (A).
    """
    changed = 0 < state.restarts < _MOST_RESTARTS
    in_vain = current_sum > (1.0 - CHANGED) * state.initial_power
    near = state.offset - state.forbidden <= NEAR * state.first_step
    heavier = current_sum > (1.0 + CHANGED) * state.forbidden_power
    kept: bool = changed and in_vain and near and (heavier or state.lost_at == -inf)
    return kept


@inlined
def is_repeated(state: Any) -> bool:
    """Return True if the load seemed to have changed at this angle before, after many restarts at a smaller one too."""
    passed: bool = state.offset >= state.jolted_at - 1.5 * state.first_step
    near: bool = state.offset <= state.jolted_at + NEAR * state.first_step
    return passed and (near or state.restarts >= _MOST_RESTARTS)


@inlined
def rearm_here(state: Any) -> None:
    """Restart the search, because the load seems to have changed, and store the angle at which it did."""
    offset, restarts = state.offset, state.restarts
    rearm(state)
    state.jolted_at = offset
    state.restarts = restarts + 1


@inlined
def rearm_unless_repeated(state: Any) -> bool:
    """Restart the search, because the load seems to have changed, and return True.

    If the same was seen at this angle, or a smaller one, return False instead. A load changes at any angle; what
    repeats where the search has been is the effect of its steps.
    """
    if state.moved != 0.0 and is_repeated(state):
        return False
    rearm_here(state)
    return True


@inlined
def may_step_farther(state: Any, current_sum: float, change: float) -> bool:
    """Return True if twice the last step could still be distinguished from another load.

    Its effects on the current sum and the speed are in proportion to the step. `change` is the change of the mean
    current sum by the step (A).
    """
    calm = min(state.calm_error, state.worst_error)
    # If a step was too large before, the next one must not appear to lose the torque.
    jolt = ALARM if state.retried != NOT_RETRIED else JOLT
    jolts = 2.0 * state.worst_error - calm > disturbed_speed_error(state, jolt, calm)
    return not jolts and 2.0 * abs(change) <= LOAD_CHANGED * current_sum
