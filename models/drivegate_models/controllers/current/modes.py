"""The modes of a guarded search, and how each begins."""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.forbidden_angle import allow_all_angles
from drivegate_models.controllers.current.state import (
    FOLLOWING,
    HOLDING,
    NOT_PROBED,
    NOT_RETRIED,
    PROBED,
    PROBING,
    SETTLING,
)

SURE: Final = 1.3
"""Ratio of peak EMF to supply from which a limited current always needs more."""

# Ratios from which it may need more: under a heavy load (a share of the maximum current sum), under one that is not
# very light, and under any.
_TRIED: Final = 0.8
_HEAVY: Final = 0.2
_TRIED_UNLESS_VERY_LIGHT: Final = 1.0
_VERY_LIGHT: Final = 0.05
_TRIED_UNDER_ANY_LOAD: Final = 1.2


@inlined
def begin_settling(state: Any) -> None:
    """Start a new decision interval, and wait until the current sum repeats before the next step."""
    state.mode = SETTLING
    state.old_power = inf
    state.moved = 0.0
    state.quiet = 0
    state.improvements = 0
    state.count = 0
    state.power_sum = 0.0
    state.worst_error = 0.0
    state.saturated = 0
    state.saturated_run = 0
    state.starved_run = 0
    state.waited = 0
    if state.probe == PROBING:
        # It has cost speed, or the load has changed meanwhile.
        state.probe = PROBED


@inlined
def forget_good_angle(state: Any) -> None:
    """Let no good angle be known: what it needed was found under another load, or with another regulation."""
    state.good_integral = inf
    state.good_power = inf


@inlined
def rearm(state: Any) -> None:
    """Return to the initial angle and reset all findings, because command or load has changed."""
    state.offset = 0.0
    state.step = state.first_step
    # The initial line is above the edge, so less angle needs less current.
    state.direction = -1.0
    allow_all_angles(state)
    state.forbidden_power = 0.0
    state.retried = NOT_RETRIED
    forget_good_angle(state)
    state.climb = 0.5 * state.first_step
    state.regained = -inf
    state.calm_error = inf
    state.confirmed = 0
    state.widened = 0
    state.probe = NOT_PROBED
    state.unsettled = 0
    state.reversals = 0
    state.grows = 1
    state.jolted_at = inf
    state.restarts = 0
    state.lost_speed = inf
    state.initial_power = 0.0
    state.follows = 1
    state.compared = 0
    state.lightened = 0
    state.kept_power = inf
    state.followed_power = inf
    state.lowest = -inf
    begin_settling(state)


@inlined
def hold_angle(state: Any, current_sum: float) -> None:
    """Hold the present angle, at which the current sum is `current_sum` (A)."""
    state.mode = HOLDING
    state.held_power = current_sum
    state.rest_power = inf
    # Without a preceding step, this is the only good angle known.
    if state.good_power == inf:
        state.good_offset = state.offset
        state.good_integral = state.integral
        state.good_power = current_sum
    state.moved = 0.0
    state.quiet = 0


@inlined
def may_follow(state: Any) -> bool:
    """Return True if the angle may regulate the speed, and it is not known yet whether that needs less.

    Below the initial angle, where the EMF limits the current: the lower the EMF, the heavier the load must be.
    """
    load = _HEAVY
    if state.emf_over_supply >= _TRIED_UNLESS_VERY_LIGHT:
        load = _VERY_LIGHT
    if state.emf_over_supply >= _TRIED_UNDER_ANY_LOAD:
        load = 0.0
    possible = state.angle_proportional > 0.0 and state.emf_over_supply >= _TRIED
    likely = possible and not is_current_below(state, load)
    return bool(likely and state.follows == 1 and state.compared == 0 and state.offset < 0.0)


@inlined
def is_following(state: Any) -> bool:
    """Return True if the angle regulates the speed; below base speed there is none."""
    return bool(state.mode == FOLLOWING and state.advancing == 1)


@inlined
def begin_following(state: Any) -> None:
    """Let the angle regulate the speed from now on, and the current rise to its limit."""
    state.mode = FOLLOWING
    state.followed_intervals = 0
    state.angle_integral = state.offset
    state.angle_gain = 1.0
    state.freed_reference = min(state.integral, state.current_limit)
    state.quiet = 0


@inlined
def stop_following(state: Any, current_sum: float, again: bool) -> None:
    """Regulate the speed by the current again, and restart the search.

    `current_sum` is the one that flows (A), and `again` whether the angle may regulate the speed again under the load.
    """
    rearm(state)
    state.integral = min(current_sum / state.conducting_phases, state.current_limit)
    state.follows = 1 if again else 0
