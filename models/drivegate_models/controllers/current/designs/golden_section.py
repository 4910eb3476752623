"""The design that narrows a bracket of the advance angle by the golden ratio (Kiefer, 1953)."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.designs.state import LOWEST_ANGLE

_RATIO: Final = 0.6180339887498949
_TOLERANCE = radians(1.5)
# The way back leads up by the last step, and that may have been twice the first.
_LAST_STEPS = 2.0


@inlined
def begin_golden_section(state: Any) -> float:
    """Bracket the optimum between almost no advance and the starting angle.

    Returns
    -------
    float
        First offset to probe (rad electrical).
    """
    state.low = LOWEST_ANGLE - state.line
    state.high = state.home
    state.falls = 1
    return divide(state)


@inlined
def divide(state: Any) -> float:
    """Place both inner points anew; the right one is the first to be probed.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    width = state.high - state.low
    state.left = state.high - _RATIO * width
    state.right = state.low + _RATIO * width
    state.stage = 0
    probe: float = state.right
    return probe


@inlined
def continue_golden_section(state: Any, power: float) -> float:
    """Drop the part of the bracket beyond the dearer of its two inner points, or that without torque.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `stage` says whether the first right, a left or a right point was probed.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset to probe (rad electrical).
    """
    if power == inf:
        state.low = max(state.low, state.controller.forbidden)
        if state.falls == 1:
            # Each step down to here saved current, so the optimum is no farther above than the last ones.
            state.high = min(state.high, state.controller.offset + _LAST_STEPS * state.controller.first_step)
            state.falls = 0
        if state.stage == 1 and state.controller.last_power < state.right_power:
            # On the way to the left point it became cheaper than at the right one, until the torque was lost.
            state.high = min(state.high, state.right)
        state.finished = 1 if state.high - state.low < _TOLERANCE else 0
        return divide(state)
    state.falls = 1
    if state.stage == 0:
        state.right_power = power
        state.stage = 1
        first: float = state.left
        return first
    if state.stage == 1:
        state.left_power = power
    else:
        state.right_power = power
    # By the golden ratio the inner point that stays is in place again: each part dropped costs one probe.
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
