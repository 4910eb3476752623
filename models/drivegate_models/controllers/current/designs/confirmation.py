"""Confirming what a search has found: its neighbours are tried, and a cheaper one is followed.

A load that changes during a search leaves a bracket that no longer holds the optimum. Probes beside the angle found
reveal it, whatever the search.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.designs.state import LOWEST_ANGLE
from drivegate_models.controllers.current.forbidden_angle import LIGHT, MARGIN, allow_all_angles
from drivegate_models.controllers.current.retry import may_retry, retry
from drivegate_models.controllers.current.unrest import is_uneasy

OFF_EDGE: Final = radians(0.8)
"""Farther from the edge than a search goes: at rest, noise alone must not lead over it (rad electrical)."""

UNCONFIRMED: Final = 0
"""Nothing to confirm yet."""
AT_ANGLE: Final = 1
"""The angle found is read again."""
BELOW: Final = 2
"""The neighbour below is tried."""
DOWN: Final = 3
"""An angle below was cheaper, and the way leads on."""
ABOVE: Final = 4
"""Angles above are tried as long as they are cheaper."""

_STRIDE = radians(0.8)
_GROWTH = 1.5
_LONGEST_STRIDE = radians(2.0)
_CHEAPER = 0.001
# Of the current sum: half of what a rest may cost.
_DEAR = 0.01
_OTHER_EDGE = 0.97
_OTHER_LOAD = 0.05


@inlined
def lowest_rest(controller: Any) -> float:
    """Return the lowest angle to rest at, off the edge that is known.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    # A small step shows the edge a little late, and the way back from it forbids more than that.
    known = controller.lost_at > -inf
    edge = 0.5 * (controller.lost_at + controller.forbidden) if known else controller.forbidden
    lowest: float = max(edge + OFF_EDGE, controller.forbidden + MARGIN)
    return lowest


@inlined
def is_worth_confirming(state: Any) -> bool:
    """Return whether neighbours can be compared: at light load they differ by less than a step disturbs.

    Returns
    -------
    bool
        About the present load.
    """
    return not draws_less_than(state.controller, LIGHT)


@inlined
def is_kept_from_cheaper(state: Any) -> bool:
    """Return whether an edge bounds the angle found, and the distance to keep from it costs much.

    Returns
    -------
    bool
        By the mean fall of the current sum from the starting angle on.
    """
    at_edge = state.best_offset - _STRIDE < lowest_rest(state.controller)
    fall = (state.home_power - state.best_power) * OFF_EDGE
    dear: bool = fall > _DEAR * state.best_power * (state.home - state.best_offset)
    return at_edge and dear


@inlined
def begin_confirmation(state: Any) -> float:
    """Return to the angle found, to read it again.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    state.finished = 0
    state.confirming = AT_ANGLE
    state.stride = _STRIDE
    if is_kept_from_cheaper(state) and may_retry(state.controller, False):
        # Long strides have lost the torque: small ones may go on.
        retry(state.controller, False)
    state.best_offset = max(state.best_offset, lowest_rest(state.controller))
    found: float = state.best_offset
    return found


@inlined
def beside(state: Any, direction: float) -> float:
    """Return the neighbour of the cheapest angle; the confirmation ends where there is none.

    Parameters
    ----------
    direction : float
        Less than zero below, else above.

    Returns
    -------
    float
        Offset to probe (rad electrical).
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
def continue_confirmation(state: Any, power: float) -> float:
    """Take in a probe, and choose the next one.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `confirming` says where the last probe was.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset to probe (rad electrical); once `finished`, `best_offset` is where to rest.
    """
    controller = state.controller
    if state.confirming == AT_ANGLE:
        if power == inf:
            return begin_confirmation(state)
        state.best_power = power
        state.best_offset = controller.offset
        if power < _OTHER_EDGE * controller.forbidden_power:
            # A lighter load has a lower edge.
            allow_all_angles(controller)
        state.confirming = BELOW
        return beside(state, -1.0)
    if power < inf and abs(power - state.best_power) > _OTHER_LOAD * power:
        # No stride explains that: the load has changed meanwhile.
        state.best_offset = controller.offset
        return begin_confirmation(state)
    direction = 1.0 if state.confirming == ABOVE else -1.0
    if power < (1.0 - _CHEAPER) * state.best_power and not is_uneasy(controller):
        state.best_power = power
        state.best_offset = controller.offset
        if direction < 0.0:
            state.confirming = DOWN
        state.stride = min(_GROWTH * state.stride, _LONGEST_STRIDE)
        return beside(state, direction)
    if direction < 0.0 and state.stride > _STRIDE:
        # Too far: the optimum, or the edge, lies between.
        state.stride = max(0.5 * state.stride, _STRIDE)
        return beside(state, -1.0)
    if state.confirming == BELOW:
        state.confirming = ABOVE
        return beside(state, 1.0)
    state.finished = 1
    found: float = state.best_offset
    return found
