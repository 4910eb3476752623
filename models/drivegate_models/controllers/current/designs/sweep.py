"""The design that sweeps the advance angle, coarsely and then finely, and returns to the minimum current sum."""

from __future__ import annotations

from math import radians
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.designs.confirmation import is_worth_confirming
from drivegate_models.controllers.current.designs.state import LOWEST_ANGLE

_COARSE = radians(2.0)
_FINE = radians(0.5)
_COARSE_RISE = 1.05
_FINE_RISE = 1.01
_AROUND = radians(1.25)


@inlined
def begin_sweep(state: Any) -> float:
    """Sweep down from the starting angle, and return the first offset to probe (rad electrical).

    `left` is the cheapest offset, `right` the last one, and `low` the end of the sweep.
    """
    state.left = state.home
    state.left_power = state.home_power
    state.low = LOWEST_ANGLE - state.line
    state.right = state.home - _COARSE
    probe: float = state.right
    return probe


@inlined
def continue_sweep(state: Any, current_sum: float) -> float:
    """Continue down until the current sum rises or the torque is lost, then sweep finely around the minimum.

    `stage` is 0 during the coarse sweep, 1 on the way back up and 2 during the fine sweep. `current_sum` is what
    the last probe cost (A), infinite if the torque was lost. Return the next offset to probe (rad electrical).
    """
    # At the top of the fine sweep, replace the value that the coarse sweep measured there.
    if state.stage == 1 or current_sum < state.left_power:
        state.left = state.right
        state.left_power = current_sum
    # Ignore a small rise: at light load the current sum has local minima.
    ended = current_sum > state.left_power * (_COARSE_RISE if state.stage == 0 else _FINE_RISE)
    step = _COARSE if state.stage == 0 else _FINE
    ended = ended or state.right - step < state.low
    if state.stage == 0 and ended and is_worth_confirming(state):
        state.stage = 1
        state.low = max(state.low, state.left - _AROUND)
        # Like the coarse sweep, the fine sweep descends from the side that provides the torque.
        state.right = min(state.left + _AROUND, state.home)
    elif ended:
        state.best_offset = state.left
        state.finished = 1
    else:
        state.stage = 2 if state.stage > 0 else 0
        state.right -= step
    probe: float = state.right
    return probe
