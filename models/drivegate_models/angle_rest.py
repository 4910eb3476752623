"""How the designs watch the angle that they rest at: for a changed load, and for an edge that is too near."""

from __future__ import annotations

from math import pi, radians
from typing import Any

from drivegate_models.angle_movement import (
    CREEP,
    CREEP_LEAST,
    LOAD_CHANGED,
    MOST_RESTARTS,
    SMALLEST_CHANGE,
    begin_anew,
)
from drivegate_models.compilation import (
    unfused,
)
from drivegate_models.design_state import SWEEP
from drivegate_models.regulation_guard import UNEASY
from drivegate_models.regulation_recovery import creeps, look_again, winds_up

_LOAD_STEPPED = 0.02
_LOAD_DRIFTED = 0.04
_LIGHT_SCALE = 2.5
_TRACKING = 0.02
_MEMORY = 40
_EARLY = 5.3
_RESTLESS_EARLY = 0.0025
_RESTLESS = 0.006
_MOST_ESCAPES = 4
_QUIET = 0.05 * pi / 30.0
_UNEASY_CREEP = 0.2 * pi / 30.0
_STEP_AWAY = radians(0.25)


@unfused
def begin_rest(state: Any, power: float) -> None:
    """Note what is needed at the angle to rest at; look again where it is not what the search has found.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With the first complete interval in which the regulator has settled.
    power : float
        Mean current sum of the interval (A).
    """
    if state.escapes == 0 or state.grain > 1.0:
        state.first_held_power = power
    elif abs(power - state.first_held_power) > LOAD_CHANGED * power:
        # A short step away does not explain it.
        look_again(state)
        return
    state.held_power = power
    state.lowest_power = power
    state.highest_power = power
    state.held_integral = state.integral_sum / state.count
    state.good_offset = state.offset
    state.good_integral = state.held_integral
    # A sweep measures in passing, and under a light load the current sum repeats less well.
    scale = (2.0 if state.design == SWEEP else 1.0) * (1.0 if state.grain == 1.0 else _LIGHT_SCALE)
    surprising = abs(power - state.best_power) > scale * LOAD_CHANGED * power + SMALLEST_CHANGE
    if surprising and state.restarts < MOST_RESTARTS:
        begin_anew(state)


@unfused
def noise_of_power(state: Any) -> float:
    """Return what the regulator's answer to the speed sensor's steps makes of the current sum.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state; the starting angle tells how much the speed seems to vary at rest.

    Returns
    -------
    float
        Current sum (A).
    """
    noise: float = state.proportional * min(max(state.home_error - _QUIET, 0.0), UNEASY)
    return noise


@unfused
def is_restless(state: Any, power: float) -> bool:
    """Return whether the current sum varies too much to rest here, and another angle may still be tried.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated with the interval.
    power : float
        Mean current sum of the interval (A).

    Returns
    -------
    bool
    """
    if state.intervals % _MEMORY == 0:
        state.lowest_power = power
        state.highest_power = power
    state.lowest_power = min(state.lowest_power, power)
    state.highest_power = max(state.highest_power, power)
    spread = state.highest_power - state.lowest_power
    noise = noise_of_power(state)
    fine = state.grain == 1.0
    if state.age * state.control_period >= _EARLY:
        # Once the search counts as ended, a long step does more harm than a restless angle.
        ended: bool = fine and spread > _RESTLESS * power + 1.5 * noise and state.escapes < _MOST_ESCAPES
        return ended
    restless: bool = spread > _RESTLESS_EARLY * power + noise
    return restless and state.escapes < (_MOST_ESCAPES if fine else 2 * _MOST_ESCAPES)


@unfused
def step_away(state: Any, power: float) -> None:
    """Rest a little farther from the edge.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    power : float
        Mean current sum of the interval (A).
    """
    # What the integral has wound up in vain is not taken along.
    state.integral = min(state.integral, CREEP * state.good_integral + CREEP_LEAST)
    if winds_up(state, state.integral, power):
        state.integral = CREEP * state.home_ratio * power
    state.forbidden = max(state.forbidden, state.offset)
    # Later steps are longer, so that there are few.
    state.best_offset = min(state.offset + (1 + state.escapes // 2) * _STEP_AWAY * state.grain, state.home)
    state.escapes += 1
    state.target = state.best_offset
    state.intervals = 0
    state.restarts = MOST_RESTARTS
    state.best_power = power


@unfused
def rest(state: Any, power: float) -> None:
    """Watch what was found: search anew after a change of load, and keep off an edge that is too near.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With a complete interval.
    power : float
        Mean current sum of the interval (A).
    """
    state.intervals += 1
    if state.intervals == 1:
        # The regulator still settles.
        return
    if state.intervals == 2:
        begin_rest(state, power)
        return
    change = abs(power - state.held_power)
    state.held_power += _TRACKING * (power - state.held_power)
    uneasy = is_restless(state, power) or state.worst_error > UNEASY
    creeping = creeps(state, state.held_integral, power, state.held_power)
    if state.grain == 1.0:
        creeping = creeping or winds_up(state, state.integral_sum / state.count, power)
    else:
        creeping = creeping and state.worst_error > _UNEASY_CREEP + 1.5 * state.home_error
    # Under a light load the current sum repeats less well.
    scale = 1.0 if state.grain == 1.0 else _LIGHT_SCALE
    drifted = abs(power - state.first_held_power) > scale * _LOAD_DRIFTED * power + 0.2
    if change > scale * _LOAD_STEPPED * power + 0.1 + noise_of_power(state) or drifted:
        state.repeats += 1
        if state.repeats >= 2 or drifted:
            look_again(state)
        return
    state.repeats = 0
    if creeping or (uneasy and state.offset < state.home):
        step_away(state, power)
