"""The angles that a search avoids because they lost the torque, and when they are allowed again."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.state import HOLDING, NOT_RETRIED, SMALLEST_STEP, STEPPED_OFF

MARGIN: Final = radians(0.2)
"""Minimum distance of a search from a forbidden angle (rad electrical)."""
LIGHT: Final = 0.15
"""Share of the maximum current sum below which a load is light: there, the cost of an angle matters little."""
# Shares of the first step. A larger step costs speed that returns; under a heavy load a smaller one may, too.
_SURE_STEP = 1.2
_SURE_STEP_UNDER_LOAD = 0.6
# Share of a step that lost the torque in which the edge is not looked for again.
_SHARE_OF_STEP = 0.25
# Current sums, relative to the one at which an angle was forbidden, that indicate another load.
_LIGHTER = 0.88
_HEAVIER = 1.35
# Usually more than the return to the initial angle explains, while the current sum there is unknown.
_HEAVIER_LOAD = 1.6
_SAME_AS_INITIAL = 1.03


@inlined
def allow_all_angles(state: Any) -> None:
    """Clear the forbidden angle."""
    state.forbidden = -inf
    state.lost_at = -inf


@inlined
def forget_load(state: Any) -> None:
    """Clear what was found under a load that is no more: the forbidden angle, and the current at the initial one."""
    if state.forbidden > -inf:
        state.initial_power = 0.0
        # Once for each forbidden angle, steps may grow again.
        state.reversals = 0
    allow_all_angles(state)


@inlined
def forbid(state: Any) -> None:
    """Forbid the present angle and all smaller ones, for a load as heavy as the present one."""
    # A step off the edge while holding did not cause the loss of speed before it.
    lost_angle = state.offset - (
        SMALLEST_STEP if state.mode == HOLDING and state.quiet == STEPPED_OFF else 0.0
    )
    if -1.5 * SMALLEST_STEP < state.moved < 0.0:
        # The speed that a small step costs shows slowly, so the one before it may have been over the edge already.
        lost_angle = max(lost_angle, state.good_offset)
    # Under a light load the distance from the edge costs less than another loss of speed.
    beyond = -_SHARE_OF_STEP * min(state.moved, 0.0) if is_current_below(state, LIGHT) else 0.0
    state.forbidden = max(state.forbidden, lost_angle + beyond)
    # After a small step down, or while holding, the angle itself lost the torque, not the transient.
    sure = _SURE_STEP
    if state.tries_again == 1 and not is_current_below(state, LIGHT):
        sure = _SURE_STEP_UNDER_LOAD
    if state.mode == HOLDING or -sure * state.first_step <= state.moved < 0.0:
        state.lost_at = max(state.lost_at, lost_angle)
    # The current sum while holding is known better than the one of the interval in which the torque was lost.
    state.forbidden_power = state.held_power if state.mode == HOLDING else state.last_power


@inlined
def lowest_offset(state: Any) -> float:
    """Return the lowest offset that a search may try (rad electrical)."""
    lowest: float = max(state.forbidden + MARGIN, state.lowest)
    return lowest


@inlined
def first_direction(state: Any) -> float:
    """Return the direction of a first step: toward less angle, or toward more where none is left."""
    return 1.0 if state.offset - state.first_step < state.lowest else -1.0


@inlined
def is_explained_by_return(state: Any, current_sum: float) -> bool:
    """Return True if the return to the initial angle explains a mean current sum (A).

    False while the current sum at the initial angle is unknown.
    """
    explained: bool = current_sum <= _SAME_AS_INITIAL * state.initial_power
    return explained


@inlined
def is_heavier_load(state: Any, current_sum: float) -> bool:
    """Return True if a mean current sum (A) indicates a much heavier load than the one of the forbidden angle.

    The return to the initial angle must not explain the sum.
    """
    heavier: bool = current_sum > _HEAVIER_LOAD * state.forbidden_power
    return heavier and not is_explained_by_return(state, current_sum)


@inlined
def forget_other_load(state: Any, current_sum: float) -> None:
    """Clear the forbidden angle if the mean current sum (A) shows that it was forbidden under another load."""
    heavier = current_sum > _HEAVIER * state.forbidden_power and not is_explained_by_return(
        state, current_sum
    )
    if current_sum < _LIGHTER * state.forbidden_power or heavier:
        # A lighter load has a lower edge, and a load that has become much heavier costs speed at any angle.
        forget_load(state)
        state.retried = NOT_RETRIED
