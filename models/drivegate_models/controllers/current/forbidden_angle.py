"""The angles that a search does not go back to, since they lost the torque, and when they are forgotten."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.state import HOLDING, NOT_RETRIED, SMALLEST_STEP, STEPPED_OFF

MARGIN: Final = radians(0.2)
"""Distance that a search keeps from a forbidden angle (rad electrical)."""
LIGHT: Final = 0.15
"""Share of the greatest current sum below which a load is light: what an angle costs there matters little."""
# Of the first step. A larger one costs speed that would come back; under much load, so may a smaller one.
_SURE_STEP = 1.2
_SURE_STEP_UNDER_LOAD = 0.6
# Current sums, over that at which an angle was forbidden, that mean another load.
_LIGHTER = 0.88
_HEAVIER = 1.35
# Mostly more than the way back to the initial angle explains, as long as the current sum there is not known.
_HEAVIER_LOAD = 1.6
_SAME_AS_INITIAL = 1.03


@inlined
def allow_all_angles(state: Any) -> None:
    """Drop the forbidden angle."""
    state.forbidden = -inf
    state.lost_at = -inf


@inlined
def forbid(state: Any) -> None:
    """Forbid the present angle and those below it, for a load as heavy as the present one."""
    # A step just made off the edge while holding is not to blame for what came before it.
    blamed = state.offset - (SMALLEST_STEP if state.mode == HOLDING and state.quiet == STEPPED_OFF else 0.0)
    state.forbidden = max(state.forbidden, blamed)
    # Down a small step, or held: the angle is to blame, not the way on which the speed was lost.
    sure = _SURE_STEP
    if state.tries_again == 1 and not draws_less_than(state, LIGHT):
        sure = _SURE_STEP_UNDER_LOAD
    if state.mode == HOLDING or -sure * state.first_step <= state.moved < 0.0:
        state.lost_at = max(state.lost_at, blamed)
    # What has been held is known better than the interval in which it was lost.
    state.forbidden_power = state.held_power if state.mode == HOLDING else state.last_power


@inlined
def is_way_back(state: Any, power: float) -> bool:
    """Return whether the way back to the initial angle explains a current sum, under the load that is known.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        False as long as the current sum at the initial angle is not known.
    """
    explained: bool = power <= _SAME_AS_INITIAL * state.initial_power
    return explained


@inlined
def is_heavier_load(state: Any, power: float) -> bool:
    """Return whether the load is much heavier than the one under which an angle was forbidden.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        Whether the current sum is more than the way back to the initial angle makes of it.
    """
    heavier: bool = power > _HEAVIER_LOAD * state.forbidden_power
    return heavier and not is_way_back(state, power)


@inlined
def forget_other_load(state: Any, power: float) -> None:
    """Drop the forbidden angle where it was forbidden under another load.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).
    """
    heavier = power > _HEAVIER * state.forbidden_power and not is_way_back(state, power)
    if power < _LIGHTER * state.forbidden_power or heavier:
        # A lighter load has a lower edge; and a load that has become much heavier costs speed at any angle.
        allow_all_angles(state)
        state.retried = NOT_RETRIED
