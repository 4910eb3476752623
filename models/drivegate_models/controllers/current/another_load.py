"""What tells another load from what a search's own steps do to the current sum."""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import greatest_current_sum
from drivegate_models.controllers.current.protection import ALARM, rearm
from drivegate_models.controllers.current.state import NOT_RETRIED
from drivegate_models.controllers.current.unrest import JOLT, unrest

LOAD_CHANGED: Final = 0.12
"""Share of the current sum beyond which a search by steps of a degree takes a difference for another load."""
CHANGED: Final = 0.03
"""Share of the current sum beyond which a difference at one and the same angle is another load."""
TUNED_SUM: Final = 104.0
"""Greatest current sum of the drive that currents are tuned on (A): over it, they become shares."""

# Of what the current sum was where the search came to rest: steps off the edge cost a little, and save nothing.
_LESS = 0.01
_MORE = 0.02
_EITHER_WAY = 0.4 / TUNED_SUM
_EITHER_WAY_NEAR = 0.2 / TUNED_SUM
_EITHER_WAY_STEADY = 0.3 / TUNED_SUM


@inlined
def differs(state: Any, power: float, known: float, share: float, either_way: float) -> bool:
    """Return whether a current sum is another one than a known one.

    Parameters
    ----------
    power, known : float
        Mean current sum of the decision interval, and the one that it is compared with (A).
    share, either_way : float
        Difference that means nothing: a share of the current sum, and one of the greatest current sum (1).

    Returns
    -------
    bool
        Whether they differ by more than both together.
    """
    differ: bool = abs(power - known) > share * power + either_way * greatest_current_sum(state)
    return differ


@inlined
def is_another_load(state: Any, power: float, known: float) -> bool:
    """Return whether the current sum at one and the same angle tells of another load.

    Parameters
    ----------
    power, known : float
        Mean current sum of the decision interval, and the one before at this angle (A).

    Returns
    -------
    bool
        Whether they differ by more than a steady load's do.
    """
    return differs(state, power, known, CHANGED, _EITHER_WAY_STEADY)


@inlined
def has_moved_on(state: Any, power: float) -> bool:
    """Return whether the current sum has left that at which the search came to rest, however slowly.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, at rest.
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        False as long as nothing has been read at rest.
    """
    share = _LESS if power < state.rest_power else _MORE
    return state.rest_power < inf and differs(state, power, state.rest_power, share, _EITHER_WAY)


@inlined
def is_lighter_load(state: Any, power: float) -> bool:
    """Return whether the way back from the edge has ended at less current than the angle below took before.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        False as long as no good angle is known, and below it.
    """
    above = state.offset >= state.good_offset
    lighter: bool = above and state.good_power < inf and power < (1.0 - LOAD_CHANGED) * state.good_power
    return lighter


@inlined
def load_has_changed(state: Any, power: float, fall: float, rise: float) -> bool:
    """Return whether the current sum differs from that of the last good angle by more than angles explain.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).
    fall, rise : float
        What steps toward less and toward more angle explain, as shares of the current sum.

    Returns
    -------
    bool
        False as long as no good angle is known, and away from it.
    """
    # Farther off, the angle alone may explain the difference.
    near = abs(state.offset - state.good_offset) <= 3.0 * state.first_step
    share = fall if power < state.good_power else rise
    changed: bool = near and differs(state, power, state.good_power, share, _EITHER_WAY_NEAR)
    return changed and state.good_power < inf


@inlined
def rearm_unless_repeated(state: Any) -> bool:
    """Start anew since the load seems to have changed, unless that was so at this angle, or beyond, before.

    A load changes at any angle. What happens again where the search has been is what the steps there do.

    Returns
    -------
    bool
        Whether the search starts anew.
    """
    offset = state.offset
    if state.moved != 0.0 and offset >= state.jolted_at - 1.5 * state.first_step:
        return False
    rearm(state)
    state.jolted_at = offset
    return True


@inlined
def may_step_farther(state: Any, power: float, change: float) -> bool:
    """Return whether twice the last step would still be told from another load.

    Parameters
    ----------
    power, change : float
        Mean current sum of the decision interval, and its change by the step (A).

    Returns
    -------
    bool
        By what the step has done to current sum and speed, which are in proportion to it.
    """
    calm = min(state.calm_error, state.worst_error)
    # Where a step has been too large before, the next one must not seem to lose the torque.
    jolt = ALARM if state.retried != NOT_RETRIED else JOLT
    jolts = 2.0 * state.worst_error - calm > unrest(state, jolt, calm)
    return not jolts and 2.0 * abs(change) <= LOAD_CHANGED * power
