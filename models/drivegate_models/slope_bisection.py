"""The design that halves a bracket of the advance angle by the sign of the slope between two near probes."""

from __future__ import annotations

from math import inf, radians
from typing import Any

from drivegate_models.compilation import unfused
from drivegate_models.design_state import LOWEST_ANGLE

_TOLERANCE = radians(0.7)
_BASE = radians(1.2)


@unfused
def begin_slope_bisection(state: Any) -> float:
    """Bracket the optimum between almost no advance and the starting angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    float
        First offset to probe (rad electrical).
    """
    state.low = LOWEST_ANGLE - state.line
    state.high = state.home
    state.left = 0.5 * (state.low + state.high)
    probe: float = state.left
    return probe


@unfused
def continue_slope_bisection(state: Any, power: float) -> float:
    """Probe beside a point that keeps the torque, or halve the bracket.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `stage` is 1 while the second point of a slope is probed.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset to probe (rad electrical).
    """
    if state.stage == 0 and power < inf:
        state.left_power = power
        state.stage = 1
        beside: float = state.left + _BASE
        return beside
    if state.stage == 1 and power > state.left_power:
        state.high = state.left
    else:
        # The slope leads upward, or there is no torque below.
        state.low = state.left
    state.stage = 0
    if state.high - state.low < _TOLERANCE:
        state.finished = 1
    state.left = 0.5 * (state.low + state.high)
    probe: float = state.left
    return probe
