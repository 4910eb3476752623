"""When a search goes on among forbidden angles: a step may have cost speed that would have come back.

Where the hysteresis band lets few pulses into a half-wave, the current reference that a torque takes rises and falls by
a tenth within a few degrees. A step up one of these teeth costs speed as one over the edge does.
"""

from __future__ import annotations

from math import radians
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.forbidden_angle import LIGHT, MARGIN
from drivegate_models.controllers.current.state import (
    NOT_RETRIED,
    RETRIED,
    RETRIED_WITH_CARE,
    SMALLEST_STEP,
)

# What a rest this far from the edge costs at least, as a share of the current sum, where it costs much.
_DISTANCE = radians(0.8)
_DEAR = 0.005
# First steps that are forbidden above the angle that lost the torque for sure.
_DOUBTFUL = 2.0
_DOUBTFUL_WHERE_DEAR = 1.2


@inlined
def is_kept_from_much(state: Any) -> bool:
    """Return whether the distance that a search keeps from the edge costs much, by what its steps have saved so far.

    Returns
    -------
    bool
        Never under a light load.
    """
    power = state.last_power
    saved = (state.initial_power - power) * _DISTANCE
    much: bool = state.offset < 0.0 and saved > _DEAR * power * -state.offset
    return much and not draws_less_than(state, LIGHT)


@inlined
def may_retry(state: Any, dear: bool) -> bool:
    """Return whether angles are forbidden only since the speed was on its way back, and there is room among them.

    Parameters
    ----------
    dear : bool
        Whether to keep off them costs much.

    Returns
    -------
    bool
        Once for a load.
    """
    room = state.offset - state.lost_at >= SMALLEST_STEP + MARGIN
    far = (_DOUBTFUL_WHERE_DEAR if dear else _DOUBTFUL) * state.first_step
    doubtful: bool = state.forbidden - state.lost_at > far
    return state.retried == NOT_RETRIED and room and doubtful


@inlined
def retry(state: Any, dear: bool) -> None:
    """Allow the angles that are forbidden only since the speed was on its way back.

    Parameters
    ----------
    dear : bool
        Whether to keep off them costs much.
    """
    # In small steps from a calm speed it shows which of the forbidden angles lose the torque.
    state.retried = RETRIED_WITH_CARE if dear else RETRIED
    state.forbidden = state.lost_at


@inlined
def takes_care(state: Any) -> bool:
    """Return whether only small steps are to lead on.

    Returns
    -------
    bool
        Among angles that were forbidden, unless the load has become light.
    """
    careful: bool = state.retried == RETRIED_WITH_CARE
    return careful and not draws_less_than(state, LIGHT)
