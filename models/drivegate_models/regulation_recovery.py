"""What the designs do about a lost torque: give the angle back, wait for the speed, or add angle."""

from __future__ import annotations

from math import inf, pi, radians
from typing import Any

from drivegate_models.angle_movement import (
    ABSORB,
    CREEP,
    CREEP_LEAST,
    INTERVAL,
    LOAD_CHANGED,
    MOST_RESTARTS,
    WAIT,
    begin_anew,
    begin_interval,
    enter,
    restart,
)
from drivegate_models.compilation import (
    unfused,
)
from drivegate_models.design_state import MEASURING, MOVING, PAUSING, RECHECKING, RECOVERING, RESTING
from drivegate_models.regulation_guard import ALARMED, CHANGED, RELIEVED, STARVED, UNEASY, forget_alarms

_RECOVERED = 0.05
_PATIENCE = 0.1
_LONGEST = 1.0
_RUN_AWAY = 1.5
_RUN_AWAY_LEAST = 1.0
_AUTHORITY = 1.35
_FAR_OFF = 5.0 * pi / 30.0
_AT_ONCE = 0.6
_RECOVERY = radians(1.0)
_RAISE = radians(3.0)
_RESCUE = radians(3.0)


@unfused
def winds_up(state: Any, integral: float, power: float) -> bool:
    """Return whether much more reference is needed for a given current than at the starting angle.

    It is so just above the edge, where the torque hardly answers the reference.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state.
    integral : float
        The regulator's integral (A).
    power : float
        Current sum (A).

    Returns
    -------
    bool
    """
    wound_up: bool = integral > _AUTHORITY * state.home_ratio * power + CREEP_LEAST
    return wound_up


@unfused
def creeps(state: Any, good_integral: float, power: float, good_power: float) -> bool:
    """Return whether the regulator winds up in vain: more current reference for no more current.

    Parameters
    ----------
    state : record of DESIGN_STATE
        With a complete interval.
    good_integral, good_power : float
        The regulator's integral and the current sum to compare with (A).
    power : float
        Mean current sum of the interval (A).

    Returns
    -------
    bool
    """
    integral = state.integral_sum / state.count
    creeping: bool = integral > CREEP * good_integral + CREEP_LEAST and power < 1.015 * good_power
    return creeping


@unfused
def take_back(state: Any) -> None:
    """Give the angle back to the last good one, and forbid the present one.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.forbidden = max(state.forbidden, state.offset)
    state.offset = min(max(state.good_offset, state.offset + _RECOVERY), state.home)
    state.target = state.offset
    # The integral has wound up in vain; with the old angle goes the old current.
    state.integral = state.good_integral
    forget_alarms(state)
    enter(state, RECOVERING)


@unfused
def raise_angle(state: Any, highest: float) -> None:
    """Add angle where even the limit's current does not give the torque.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    highest : float
        Greatest offset that may give more torque (rad electrical).
    """
    if state.offset >= state.home:
        if state.home < highest:
            state.home = min(state.home + _RAISE, highest)
            state.offset = state.home
            restart(state)
    elif state.mode == RECOVERING:
        # A regulator at its limit does not come back from here, although a smaller reference gave the torque.
        state.forbidden = max(state.forbidden, state.offset)
        state.target = min(state.offset + _RESCUE, state.home)
        state.elapsed = 0


@unfused
def look_again(state: Any) -> None:
    """Return from rest to the starting angle, whose current sum tells whether the load has changed.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.disturbed_at = state.offset
    state.target = state.home
    state.pursuing = 0
    enter(state, RECHECKING)


@unfused
def respond(state: Any, report: int, highest: float) -> None:
    """Answer the regulation guard.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    report : int
        What `watch_regulation` has found.
    highest : float
        Greatest offset that may give more torque (rad electrical).
    """
    probing = state.mode in (MOVING, PAUSING, MEASURING)
    lost = report in (ALARMED, STARVED)
    # A heavy shaft hides a lost torque from the speed for a while, but not from the integral.
    runs_away = state.integral > _RUN_AWAY * state.good_integral + _RUN_AWAY_LEAST
    if report == CHANGED:
        restart(state)
    elif (lost or runs_away) and probing and state.offset < state.good_offset:
        take_back(state)
    elif (lost or (report == RELIEVED and state.target <= state.good_offset)) and probing:
        # Perhaps the load has changed: the starting angle will tell.
        state.doubtful = 1 if report == RELIEVED else 0
        state.target = state.home
        if lost:
            state.offset = state.home
        enter(state, RECOVERING)
    elif lost and state.mode == RECOVERING and state.error > _FAR_OFF:
        state.target = state.home
        state.offset = state.home
    elif state.mode == RESTING and (lost or (report == RELIEVED and state.offset == state.target)):
        if state.elapsed * state.control_period < _AT_ONCE:
            state.disturbances += 1
        look_again(state)
        if lost:
            state.offset = state.home
    elif report == STARVED:
        raise_angle(state, highest)


@unfused
def check_load(state: Any) -> None:
    """Interrupt the search, whose starting angle tells whether the load is still the same.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.target = state.home
    enter(state, RECHECKING)
    state.pursuing = 1


@unfused
def is_overloaded(state: Any, power: float) -> bool:
    """Return whether the present angle needs more current than the load that the search knows.

    The current sum is a convex function of the angle, so it lies below the chord from the best angle to the
    starting one.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state.
    power : float
        Mean current sum (A).

    Returns
    -------
    bool
        False below the best angle, and under a light load, where the curve has several minima.
    """
    width = state.home - state.best_offset
    above = state.offset - state.best_offset
    if state.grain > 1.0 or above < 0.0:
        return False
    share = above / width if width > 0.0 else 1.0
    chord = state.best_power + share * (state.home_power - state.best_power)
    overloaded: bool = power > (1.0 + LOAD_CHANGED) * chord
    return overloaded


@unfused
def recover(state: Any, saturated: bool, elapsed: float) -> int:
    """Wait until the speed is regulated again; add angle where it is not.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    saturated : bool
        Whether the current reference is at its limit.
    elapsed : float
        Time since the angle was last given back (s).

    Returns
    -------
    int
        `WAIT` or `ABSORB`.
    """
    if abs(state.error) > UNEASY or saturated:
        begin_interval(state)
    state.count += 1
    state.power_sum += state.current_sum
    at_home = state.offset == state.home
    if state.count * state.control_period >= (INTERVAL if at_home else _RECOVERED):
        power = state.power_sum / state.count
        if at_home and abs(power - state.home_power) > LOAD_CHANGED * power:
            check_load(state)
            return WAIT
        if at_home and state.doubtful == 1 and state.restarts < MOST_RESTARTS:
            # Some of the probes were made under another load.
            begin_anew(state)
            return WAIT
        wound_up = state.integral > CREEP * state.good_integral + CREEP_LEAST
        if wound_up and state.offset == state.good_offset and elapsed < _LONGEST:
            # The speed is back before the integral, since the shaft is heavy.
            state.integral = state.good_integral
            begin_interval(state)
            return WAIT
        if not at_home and is_overloaded(state, power):
            check_load(state)
            return WAIT
        state.good_offset = state.offset
        state.good_integral = state.integral
        state.old_power = inf
        return ABSORB
    if elapsed >= _PATIENCE and not at_home:
        state.elapsed = 0
        state.target = min(state.target + _RESCUE, state.home)
    if elapsed >= _LONGEST:
        restart(state)
    return WAIT
