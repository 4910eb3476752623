"""Rest only where the current sum is steady: not where regulator and hysteresis band beat, and not at the edge.

At light load a half cycle contains only a few chops, and the torque jumps where one more fits in. At an angle where
the load's torque lies within a jump, no current reference produces it. The regulator then alternates between both
sides, however it is tuned. With an encoder it may do so within one step of the measured speed, where only the
current sum shows it. Such angles are half of all, in ranges of a few degrees. At the edge itself, the current
reference creeps up for a torque that is slightly too small.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.confirmation import is_worth_confirming
from drivegate_lab.kernels.designs.probe import aim
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.unrest import EXACT, regulator_noise

LATEST_DECISION: Final = 51
"""Decisions after which the angle is final, steady or not."""

_STILL = 3
_STILL_LIGHT = 15
_RESTLESS = 3
_BEATING = 0.0035
# Shares of k1.
_UNREST = 0.006
_SENSED = 0.02
# More than one step of an encoder but less than two; steps up and down differ slightly.
_CALM = 1.5
_CREPT = 0.02
_SAME = 0.005
_SETTLING = 2
_SWING = 0.008
_SWINGING = 3
_ASIDE = radians(0.7)
_ASIDE_OF_UNREST = radians(0.9)
# Current sum relative to that at the angle found, and the share of the maximum sum below which there is too little
# to save.
_MOST_EXPENSIVE_ASIDE = 1.006
_LITTLE = 0.08


@inlined
def begin_watch(state: Any) -> None:
    """Begin to monitor the current sum at the target angle."""
    state.watched = 0
    state.still = 0
    state.restless = 0
    state.least = inf
    state.most = -inf
    state.swing_rises = 1
    state.swings = 0


@inlined
def has_swung_back(state: Any) -> bool:
    """Return True if the current sum has reversed by more than its noise, in the decision interval just ended.

    The swing is measured from the last reversal, or from where the step of the angle has settled.
    """
    current_sum = state.controller.last_power
    rises = state.swing_rises == 1
    if state.watched <= _SETTLING or (current_sum > state.swing_from) == rises:
        state.swing_from = current_sum
        return False
    swings: bool = abs(current_sum - state.swing_from) > _SWING * current_sum
    if swings:
        state.swing_rises = 0 if rises else 1
        state.swing_from = current_sum
    return swings


@inlined
def is_creeping_up(state: Any) -> bool:
    """Return True if the current reference has crept up for no more current, as it does at the edge.

    It compares with the start of monitoring, which must be at least one interval ago.
    """
    controller = state.controller
    noise = regulator_noise(controller)
    crept = controller.integral > (1.0 + _CREPT) * state.rest_integral + noise
    creeping: bool = crept and abs(controller.last_power - state.least) <= _SAME * controller.last_power
    return creeping


@inlined
def is_rest_confirmed(state: Any) -> bool:
    """Evaluate a decision interval, and return True if the angle is suitable for a rest and was monitored long enough.

    If the sum beats or its reference creeps, aim slightly higher as long as that costs little.
    """
    controller = state.controller
    current_sum = controller.last_power
    if state.watched == 0:
        state.rest_integral = controller.integral
    state.watched += 1
    # The minimum speed error is the sensor's, except where an encoder reading is exact by chance.
    if controller.worst_error > EXACT:
        state.finest = min(state.finest, controller.worst_error)
    sensed = state.finest > _SENSED * controller.speed_tolerance
    unrest_begins = _CALM * state.finest if sensed else _UNREST * controller.speed_tolerance
    restless = controller.worst_error > unrest_begins
    swings = has_swung_back(state)
    state.swings += 1 if swings else 0
    state.still = state.still + 1 if not (restless or swings) else 0
    state.restless = state.restless + 1 if restless else 0
    state.least = min(state.least, current_sum)
    state.most = max(state.most, current_sum)
    if state.decisions >= LATEST_DECISION:
        return True
    loaded = is_worth_confirming(state)
    # At light load the current sum settles slowly: swings of the sum or the speed decide.
    swings_on = not loaded and state.swings >= _SWINGING
    unrest = swings_on or (not loaded and state.restless >= _RESTLESS)
    beats = loaded and state.most - state.least > _BEATING * current_sum + regulator_noise(controller)
    cheap = current_sum < _MOST_EXPENSIVE_ASIDE * state.best_power + regulator_noise(controller)
    # Leave a swinging current sum at any cost.
    affordable = swings_on or cheap or is_current_below(controller, _LITTLE)
    if affordable and (unrest or beats or is_creeping_up(state)):
        state.best_offset = controller.offset + (_ASIDE_OF_UNREST if unrest else _ASIDE)
        aim(state, state.best_offset)
        begin_watch(state)
        return False
    is_still: bool = state.still >= (_STILL if loaded else _STILL_LIGHT) or (
        loaded and state.watched >= _STILL
    )
    return is_still


@inlined
def step_off_edge(state: Any) -> None:
    """Increase the angle slightly if the current reference creeps while the search is at rest."""
    controller = state.controller
    if is_creeping_up(state):
        controller.integral = state.rest_integral
        controller.offset += _ASIDE
        # As after any step at rest, the next interval is not evaluated.
        controller.quiet = 0
