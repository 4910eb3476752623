"""Resting where the current sum stands still: not where regulator and band beat, and not at the very edge.

At light load a half cycle holds a few chops only, and the torque climbs by a jump where one more fits in. At an angle
where the load's torque lies within a jump, no current reference gives it: the regulator goes back and forth between
both sides, however it is tuned, and through an encoder it does so within one step of the speed's measurement, where
only the current sum shows it. Such angles take up half of all, in stretches of a few degrees. And right at the edge
the current reference creeps up for a torque that is short by a trace.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.designs.confirmation import is_worth_confirming
from drivegate_models.controllers.current.designs.probe import aim
from drivegate_models.controllers.current.unrest import EXACT, noise_of_regulator

LATEST_DECISION: Final = 51
"""Decisions after which the angle is kept, still or not."""

_STILL = 3
_STILL_LIGHT = 15
_RESTLESS = 3
_BEATING = 0.0035
# Of k1.
_UNREST = 0.006
_SENSED = 0.02
# One step of an encoder is not two; up and down they differ a little.
_CALM = 1.5
_CREPT = 0.02
_SAME = 0.005
_SETTLING = 2
_SWING = 0.008
_SWINGING = 3
_ASIDE = radians(0.7)
_ASIDE_OF_UNREST = radians(0.9)
# Over the current sum at the angle found; and the share of the greatest one below which there is too little to save.
_DEAREST_ASIDE = 1.006
_LITTLE = 0.08


@inlined
def begin_watch(state: Any) -> None:
    """Begin to watch the current sum at the angle aimed at."""
    state.watched = 0
    state.still = 0
    state.restless = 0
    state.least = inf
    state.most = -inf
    state.swing_rises = 1
    state.swings = 0


@inlined
def swings_back(state: Any) -> bool:
    """Return whether the current sum has turned back from where it went, by more than its noise.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated by the decision interval just ended.

    Returns
    -------
    bool
        About the time since it turned last, or since the step of the angle has settled.
    """
    power = state.controller.last_power
    rises = state.swing_rises == 1
    if state.watched <= _SETTLING or (power > state.swing_from) == rises:
        state.swing_from = power
        return False
    swings: bool = abs(power - state.swing_from) > _SWING * power
    if swings:
        state.swing_rises = 0 if rises else 1
        state.swing_from = power
    return swings


@inlined
def creeps(state: Any) -> bool:
    """Return whether the current reference has crept up for no more current, as it does right at the edge.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state, watched for an interval at least.

    Returns
    -------
    bool
        About the time since the watch began.
    """
    controller = state.controller
    noise = noise_of_regulator(controller)
    crept = controller.integral > (1.0 + _CREPT) * state.rest_integral + noise
    creeping: bool = crept and abs(controller.last_power - state.least) <= _SAME * controller.last_power
    return creeping


@inlined
def stands_still(state: Any) -> bool:
    """Take in a decision interval; where the sum beats or its reference creeps, aim a little higher, at little cost.

    Returns
    -------
    bool
        Whether the current sum has been watched long enough, and this is an angle to rest at.
    """
    controller = state.controller
    power = controller.last_power
    if state.watched == 0:
        state.rest_integral = controller.integral
    state.watched += 1
    # Where the speed is never calmer than this, except where an encoder shows it as exact, the sensor makes the rest.
    if controller.worst_error > EXACT:
        state.finest = min(state.finest, controller.worst_error)
    sensed = state.finest > _SENSED * controller.speed_tolerance
    unrest_begins = _CALM * state.finest if sensed else _UNREST * controller.speed_tolerance
    restless = controller.worst_error > unrest_begins
    swings = swings_back(state)
    state.swings += 1 if swings else 0
    state.still = state.still + 1 if not (restless or swings) else 0
    state.restless = state.restless + 1 if restless else 0
    state.least = min(state.least, power)
    state.most = max(state.most, power)
    if state.decisions >= LATEST_DECISION:
        return True
    loaded = is_worth_confirming(state)
    # At light load the current sum takes long to settle: what counts is that it swings, or that the speed does.
    swings_on = not loaded and state.swings >= _SWINGING
    unrest = swings_on or (not loaded and state.restless >= _RESTLESS)
    beats = loaded and state.most - state.least > _BEATING * power + noise_of_regulator(controller)
    cheap = power < _DEAREST_ASIDE * state.best_power + noise_of_regulator(controller)
    # A current sum that swings is no rest at any price.
    affordable = swings_on or cheap or draws_less_than(controller, _LITTLE)
    if affordable and (unrest or beats or creeps(state)):
        state.best_offset = controller.offset + (_ASIDE_OF_UNREST if unrest else _ASIDE)
        aim(state, state.best_offset)
        begin_watch(state)
        return False
    still: bool = state.still >= (_STILL if loaded else _STILL_LIGHT) or (loaded and state.watched >= _STILL)
    return still


@inlined
def keep_off_edge(state: Any) -> None:
    """Go a little higher where the current reference creeps while the search is at rest."""
    controller = state.controller
    if creeps(state):
        controller.integral = state.rest_integral
        controller.offset += _ASIDE
        # As after any step at rest, the next interval is not judged.
        controller.quiet = 0
