"""The design that sweeps the advance angle, coarse and fine, and returns to where the current sum was least."""

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
    """Sweep down from the starting angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `left` is the cheapest offset, `right` the last one, `low` the end of the sweep.

    Returns
    -------
    float
        First offset to probe (rad electrical).
    """
    state.left = state.home
    state.left_power = state.home_power
    state.low = LOWEST_ANGLE - state.line
    state.right = state.home - _COARSE
    probe: float = state.right
    return probe


@inlined
def continue_sweep(state: Any, power: float) -> float:
    """Go on down until the current sum rises or the torque is lost; then sweep finely about the least.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `stage` is 0 during the coarse sweep, 1 on the way back up, 2 during the fine sweep.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset to probe (rad electrical).
    """
    # Back at the top of the fine sweep, what the coarse one measured there is no longer compared with.
    if state.stage == 1 or power < state.left_power:
        state.left = state.right
        state.left_power = power
    # A small rise is passed over: at light load the current sum has minima beside the least.
    ended = power > state.left_power * (_COARSE_RISE if state.stage == 0 else _FINE_RISE)
    step = _COARSE if state.stage == 0 else _FINE
    ended = ended or state.right - step < state.low
    if state.stage == 0 and ended and is_worth_confirming(state):
        state.stage = 1
        state.low = max(state.low, state.left - _AROUND)
        # The fine sweep comes down like the coarse one, from the side that has the torque.
        state.right = min(state.left + _AROUND, state.home)
    elif ended:
        state.best_offset = state.left
        state.finished = 1
    else:
        state.stage = 2 if state.stage > 0 else 0
        state.right -= step
    probe: float = state.right
    return probe
