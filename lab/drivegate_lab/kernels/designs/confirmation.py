"""Confirmation of a search's result: try the neighbours of the angle, and follow a cheaper one.

A load that changes during a search leaves a bracket that no longer contains the optimum. Probes next to the angle
found reveal this, whatever the search.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.state import LOWEST_ANGLE
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.forbidden_angle import LIGHT, MARGIN, allow_all_angles
from drivegate_models.controllers.current.retry import may_retry, retry
from drivegate_models.controllers.current.unrest import is_speed_unsteady

OFF_EDGE: Final = radians(0.8)
"""Distance to the edge at rest (rad electrical): larger than during a search, so that noise cannot cross the edge."""

UNCONFIRMED: Final = 0
"""Nothing to confirm yet."""
AT_ANGLE: Final = 1
"""The angle found is measured again."""
BELOW: Final = 2
"""The neighbour below is tried."""
DOWN: Final = 3
"""An angle below was cheaper, so the search continues downward."""
ABOVE: Final = 4
"""Angles above are tried as long as they are cheaper."""

_STRIDE = radians(0.8)
_GROWTH = 1.5
_LONGEST_STRIDE = radians(2.0)
_CHEAPER = 0.001
# Share of the current sum: half of the allowed excess at rest.
_COSTLY = 0.01
_OTHER_EDGE = 0.97
_OTHER_LOAD = 0.05


@inlined
def lowest_rest(controller: Any) -> float:
    """Return the lowest offset from the initial angle at which to rest, off the known edge (rad electrical)."""
    # A small step detects the edge slightly late, and reverting it forbids more than that.
    known = controller.lost_at > -inf
    edge = 0.5 * (controller.lost_at + controller.forbidden) if known else controller.forbidden
    lowest: float = max(edge + OFF_EDGE, controller.forbidden + MARGIN)
    return lowest


@inlined
def is_worth_confirming(state: Any) -> bool:
    """Return True if neighbours can be compared; at light load they differ by less than a step disturbs."""
    return not is_current_below(state.controller, LIGHT)


@inlined
def is_edge_distance_costly(state: Any) -> bool:
    """Return True if an edge bounds the angle found, and the distance to it is costly.

    The cost is judged by the mean slope of the current sum since the starting angle.
    """
    at_edge = state.best_offset - _STRIDE < lowest_rest(state.controller)
    fall = (state.home_power - state.best_power) * OFF_EDGE
    costly: bool = fall > _COSTLY * state.best_power * (state.home - state.best_offset)
    return at_edge and costly


@inlined
def begin_confirmation(state: Any) -> float:
    """Return the offset of the angle found (rad electrical), to measure it again."""
    state.finished = 0
    state.confirming = AT_ANGLE
    state.stride = _STRIDE
    if is_edge_distance_costly(state) and may_retry(state.controller, False):
        # Long strides have lost the torque; small ones may continue.
        retry(state.controller, False)
    state.best_offset = max(state.best_offset, lowest_rest(state.controller))
    found: float = state.best_offset
    return found


@inlined
def neighbour_offset(state: Any, direction: float) -> float:
    """Return the offset of the cheapest angle's neighbour (rad electrical), below it if `direction` is negative.

    Finish the confirmation if there is none.
    """
    if direction < 0.0:
        lowest = max(LOWEST_ANGLE - state.line, state.controller.forbidden + MARGIN)
        while state.best_offset - state.stride < lowest and state.stride > _STRIDE:
            state.stride = max(0.5 * state.stride, _STRIDE)
        below: float = state.best_offset - state.stride
        if below >= lowest:
            return below
        if state.confirming == DOWN:
            state.finished = 1
            return below
        state.confirming = ABOVE
    above: float = state.best_offset + state.stride
    return above


@inlined
def continue_confirmation(state: Any, current_sum: float) -> float:
    """Evaluate a probe, and return the next offset to probe (rad electrical).

    `confirming` states where the last probe was and `current_sum` what it cost (A), infinite if the torque was
    lost. Once `finished`, rest at `best_offset`.
    """
    controller = state.controller
    if state.confirming == AT_ANGLE:
        if current_sum == inf:
            return begin_confirmation(state)
        state.best_power = current_sum
        state.best_offset = controller.offset
        if current_sum < _OTHER_EDGE * controller.forbidden_power:
            # A lighter load has a lower edge.
            allow_all_angles(controller)
        state.confirming = BELOW
        return neighbour_offset(state, -1.0)
    if current_sum < inf and abs(current_sum - state.best_power) > _OTHER_LOAD * current_sum:
        # No stride explains this change: the load has changed meanwhile.
        state.best_offset = controller.offset
        return begin_confirmation(state)
    direction = 1.0 if state.confirming == ABOVE else -1.0
    if current_sum < (1.0 - _CHEAPER) * state.best_power and not is_speed_unsteady(controller):
        state.best_power = current_sum
        state.best_offset = controller.offset
        if direction < 0.0:
            state.confirming = DOWN
        state.stride = min(_GROWTH * state.stride, _LONGEST_STRIDE)
        return neighbour_offset(state, direction)
    if direction < 0.0 and state.stride > _STRIDE:
        # The stride was too long: the optimum, or the edge, lies in between.
        state.stride = max(0.5 * state.stride, _STRIDE)
        return neighbour_offset(state, -1.0)
    if state.confirming == BELOW:
        state.confirming = ABOVE
        return neighbour_offset(state, 1.0)
    state.finished = 1
    found: float = state.best_offset
    return found
