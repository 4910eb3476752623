"""The design that goes to the vertex of a parabola through three probes (Powell, 1964)."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.designs.state import LOWEST_ANGLE

MOST_PROBES: Final = 16
"""Probes after which the search ends whatever it has found."""

_STRIDE = radians(7.0)
_NARROW = radians(0.7)
_CLOSE = radians(2.0)


@inlined
def begin_quadratic_interpolation(state: Any) -> float:
    """Stride downward from the starting angle.

    Returns
    -------
    float
        First offset to probe (rad electrical).
    """
    state.high = state.home
    state.high_power = state.home_power
    # `left` is the cheapest point so far, between low and high.
    state.left = state.home
    state.left_power = state.home_power
    return next_stride(state)


@inlined
def next_stride(state: Any) -> float:
    """Return the point one stride below the cheapest.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    # Downward, since the initial angle has the torque, and the edge beyond which it is lost lies below.
    lowest = LOWEST_ANGLE - state.line
    state.low = max(state.left - _STRIDE, lowest)
    if state.left - lowest < _NARROW:
        state.finished = 1
    state.right = state.low
    probe: float = state.right
    return probe


@inlined
def vertex(state: Any) -> float:
    """Return the vertex of the parabola through low, left and high.

    Parameters
    ----------
    state : record of DESIGN_STATE
        A bracket whose middle is the cheapest, all powers finite.

    Returns
    -------
    float
        Offset (rad electrical), infinite where the three lie on a line.
    """
    below = state.left - state.low
    above = state.high - state.left
    rise_below = (state.low_power - state.left_power) * above
    rise_above = (state.high_power - state.left_power) * below
    curvature = rise_below + rise_above
    if curvature <= 0.0:
        return inf
    found: float = state.left + 0.5 * (rise_below * above - rise_above * below) / curvature
    return found


@inlined
def narrow(state: Any) -> float:
    """Choose the next point within the bracket, by the parabola where there is one.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; finished where the bracket is narrow enough.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    state.low = max(state.low, state.controller.forbidden)
    below = state.left - state.low
    above = state.high - state.left
    done_below = below < (_NARROW if state.low_power == inf else _CLOSE)
    done_above = above < _CLOSE
    if done_below and done_above:
        state.finished = 1
    if done_above and state.low_power == inf:
        # The edge lies below: no parabola goes through it.
        probe = state.left - 0.5 * below
    elif state.low_power == inf or above <= 0.0 or below <= 0.0:
        probe = state.left - 0.5 * below if not done_below else state.left + 0.3 * above
    else:
        probe = vertex(state)
        nearest = 0.15 * max(below, above)
        if not abs(probe - state.left) >= nearest:
            # Too near to be distinguished: look into the longer side.
            probe = state.left - 0.4 * below if below > above else state.left + 0.4 * above
        # Close to an end a probe would hardly narrow the bracket.
        probe = min(max(probe, state.low + 0.15 * below), state.high - 0.15 * above)
    state.right = probe
    chosen: float = probe
    return chosen


@inlined
def continue_quadratic_interpolation(state: Any, power: float) -> float:
    """Take in a probe, and narrow the bracket around the cheapest point.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `stage` is 0 while the bracket is looked for.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset to probe (rad electrical).
    """
    state.probes += 1
    if state.probes >= MOST_PROBES:
        state.finished = 1
    cheaper = power < state.left_power
    if state.stage == 0:
        if cheaper:
            state.high = state.left
            state.high_power = state.left_power
            state.left = state.right
            state.left_power = power
            return next_stride(state)
        state.low_power = power
        state.stage = 1
        return narrow(state)
    if state.right < state.left:
        if cheaper:
            state.high = state.left
            state.high_power = state.left_power
        else:
            state.low = state.right
            state.low_power = power
    elif cheaper:
        state.low = state.left
        state.low_power = state.left_power
    else:
        state.high = state.right
        state.high_power = power
    if cheaper:
        state.left = state.right
        state.left_power = power
    return narrow(state)
