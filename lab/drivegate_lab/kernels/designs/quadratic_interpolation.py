"""The design that moves to the vertex of a parabola through three probes (Powell, 1964)."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.state import LOWEST_ANGLE
from drivegate_models.compilation.kernels import inlined

MOST_PROBES: Final = 16
"""Probes after which the search ends in any case."""

_STRIDE = radians(7.0)
_NARROW = radians(0.7)
_CLOSE = radians(2.0)


@inlined
def begin_quadratic_interpolation(state: Any) -> float:
    """Stride downward from the starting angle, and return the first offset to probe (rad electrical)."""
    state.high = state.home
    state.high_power = state.home_power
    # `left` is the cheapest point so far, between low and high.
    state.left = state.home
    state.left_power = state.home_power
    return next_stride(state)


@inlined
def next_stride(state: Any) -> float:
    """Return the offset one stride below the cheapest point (rad electrical)."""
    # Go downward: the initial angle provides the torque, and the edge beyond which it is lost lies below.
    lowest = LOWEST_ANGLE - state.line
    state.low = max(state.left - _STRIDE, lowest)
    if state.left - lowest < _NARROW:
        state.finished = 1
    state.right = state.low
    probe: float = state.right
    return probe


@inlined
def vertex(state: Any) -> float:
    """Return the vertex of the parabola through low, left and high (rad electrical), infinite if they lie on a line.

    The middle point must be the cheapest, and all current sums finite.
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
    """Return the next offset within the bracket (rad electrical), by the parabola if there is one.

    Finish the search if the bracket is narrow enough.
    """
    state.low = max(state.low, state.controller.forbidden)
    below = state.left - state.low
    above = state.high - state.left
    done_below = below < (_NARROW if state.low_power == inf else _CLOSE)
    done_above = above < _CLOSE
    if done_below and done_above:
        state.finished = 1
    if done_above and state.low_power == inf:
        # The edge lies below, so there is no parabola.
        probe = state.left - 0.5 * below
    elif state.low_power == inf or above <= 0.0 or below <= 0.0:
        probe = state.left - 0.5 * below if not done_below else state.left + 0.3 * above
    else:
        probe = vertex(state)
        nearest = 0.15 * max(below, above)
        if not abs(probe - state.left) >= nearest:
            # The points are too close to be distinguished: probe the longer side.
            probe = state.left - 0.4 * below if below > above else state.left + 0.4 * above
        # Close to an end a probe would hardly narrow the bracket.
        probe = min(max(probe, state.low + 0.15 * below), state.high - 0.15 * above)
    state.right = probe
    chosen: float = probe
    return chosen


@inlined
def continue_quadratic_interpolation(state: Any, current_sum: float) -> float:
    """Evaluate a probe, narrow the bracket around the cheapest point, and return the next offset (rad electrical).

    `stage` is 0 until a bracket is found. `current_sum` is what the last probe cost (A), infinite if the torque was
    lost.
    """
    state.probes += 1
    if state.probes >= MOST_PROBES:
        state.finished = 1
    cheaper = current_sum < state.left_power
    if state.stage == 0:
        if cheaper:
            state.high = state.left
            state.high_power = state.left_power
            state.left = state.right
            state.left_power = current_sum
            return next_stride(state)
        state.low_power = current_sum
        state.stage = 1
        return narrow(state)
    if state.right < state.left:
        if cheaper:
            state.high = state.left
            state.high_power = state.left_power
        else:
            state.low = state.right
            state.low_power = current_sum
    elif cheaper:
        state.low = state.left
        state.low_power = state.left_power
    else:
        state.high = state.right
        state.high_power = current_sum
    if cheaper:
        state.left = state.right
        state.left_power = current_sum
    return narrow(state)
