"""The design that narrows a bracket of the advance angle by the golden ratio (Kiefer, 1953)."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.state import LOWEST_ANGLE
from drivegate_models.compilation.kernels import inlined

_RATIO: Final = 0.6180339887498949
_TOLERANCE = radians(1.5)
# Reverting adds the last step, which may have been twice the first.
_LAST_STEPS = 2.0


@inlined
def begin_golden_section(state: Any) -> float:
    """Bracket the optimum between almost no advance and the starting angle.

    Return the first offset to probe (rad electrical).
    """
    state.low = LOWEST_ANGLE - state.line
    state.high = state.home
    state.falls = 1
    return divide(state)


@inlined
def divide(state: Any) -> float:
    """Place both inner points again, and return the right one, which is probed first (rad electrical)."""
    width = state.high - state.low
    state.left = state.high - _RATIO * width
    state.right = state.low + _RATIO * width
    state.stage = 0
    probe: float = state.right
    return probe


@inlined
def continue_golden_section(state: Any, current_sum: float) -> float:
    """Drop the part of the bracket beyond the more expensive inner point, or the part without torque.

    `stage` states whether the first right, a left or a right point was probed, and `current_sum` what the last
    probe cost (A), infinite if the torque was lost. Return the next offset to probe (rad electrical).
    """
    if current_sum == inf:
        state.low = max(state.low, state.controller.forbidden)
        if state.falls == 1:
            # Each step down to here saved current, so the optimum is no farther above than the last steps.
            state.high = min(state.high, state.controller.offset + _LAST_STEPS * state.controller.first_step)
            state.falls = 0
        if state.stage == 1 and state.controller.last_power < state.right_power:
            # On the way to the left point the current fell below the right point's, until the torque was lost.
            state.high = min(state.high, state.right)
        state.finished = 1 if state.high - state.low < _TOLERANCE else 0
        return divide(state)
    state.falls = 1
    if state.stage == 0:
        state.right_power = current_sum
        state.stage = 1
        first: float = state.left
        return first
    if state.stage == 1:
        state.left_power = current_sum
    else:
        state.right_power = current_sum
    # By the golden ratio the remaining inner point is in place again: each reduction costs one probe.
    if state.left_power < state.right_power:
        state.high = state.right
        state.right = state.left
        state.right_power = state.left_power
        state.left = state.high - _RATIO * (state.high - state.low)
        state.stage = 1
    else:
        state.low = state.left
        state.left = state.right
        state.left_power = state.right_power
        state.right = state.low + _RATIO * (state.high - state.low)
        state.stage = 2
    if state.high - state.low < _TOLERANCE:
        state.finished = 1
    probe: float = state.left if state.stage == 1 else state.right
    return probe
