"""Rules for retrying forbidden angles, where a step may have cost speed that would have returned.

Where the hysteresis band allows few pulses in a half-wave, the current reference needed for a torque rises and falls
by a tenth within a few degrees. A step up one of these teeth costs speed like a step over the edge.
"""

from __future__ import annotations

from math import radians
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.forbidden_angle import LIGHT, MARGIN
from drivegate_models.controllers.current.state import (
    NOT_RETRIED,
    RETRIED,
    RETRIED_WITH_CARE,
    SMALLEST_STEP,
)

# A distance from the edge is costly if this much of it costs more than this share of the current sum.
_DISTANCE = radians(0.8)
_COSTLY = 0.005
# Forbidden range above the angle that certainly lost the torque, in first steps.
_DOUBTFUL = 2.0
_DOUBTFUL_WHERE_COSTLY = 1.2
# Range that is allowed again, in first steps: more than the longest step and its recovery. Farther, small steps would
# walk on for seconds where the current sum is flat.
_RETRIED = 3.0


@inlined
def is_edge_distance_costly(state: Any) -> bool:
    """Return True if the distance to the edge is costly, judged by the current saved so far.

    Under a light load it never is.
    """
    current_sum = state.last_power
    saved = (state.initial_power - current_sum) * _DISTANCE
    costly: bool = state.offset < 0.0 and saved > _COSTLY * current_sum * -state.offset
    return costly and not is_current_below(state, LIGHT)


@inlined
def may_retry(state: Any, costly: bool) -> bool:
    """Return True if angles are forbidden only because the speed was still returning, and some are left of them.

    `costly` states that avoiding them is costly. Angles are retried once per load.
    """
    is_free = state.offset - state.lost_at >= SMALLEST_STEP + MARGIN
    far = (_DOUBTFUL_WHERE_COSTLY if costly else _DOUBTFUL) * state.first_step
    doubtful: bool = state.forbidden - state.lost_at > far
    return state.retried == NOT_RETRIED and is_free and doubtful


@inlined
def retry(state: Any, costly: bool) -> None:
    """Allow the angles that are forbidden only because the speed was still returning."""
    # Small steps from a steady speed show which of the forbidden angles lose the torque.
    state.retried = RETRIED_WITH_CARE if costly else RETRIED
    state.forbidden = max(state.lost_at, state.forbidden - _RETRIED * state.first_step)


@inlined
def needs_small_steps(state: Any) -> bool:
    """Return True if only small steps are allowed: among retried angles, unless the load has become light."""
    small_steps: bool = state.retried == RETRIED_WITH_CARE
    return small_steps and not is_current_below(state, LIGHT)
