"""What protects the regulation from a search for the advance angle, whatever search it is.

It settles before the search begins, gives back an angle that has lost the torque, looks for one that gives it, and
starts anew where command, supply or load has changed.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.forbidden_angle import allow_all_angles, forbid
from drivegate_models.controllers.current.state import (
    HOLDING,
    NOT_RETRIED,
    RETRIED,
    SETTLING,
    SMALLEST_STEP,
)

STARVED: Final = 3.0
"""Times the current that flows by which the current reference of a starved winding exceeds it."""
SLACK: Final = 0.04
"""Current reference at which no winding counts as starved yet, as a share of the current limit."""
ALARM: Final = 0.3
"""Share of k1 whose loss after an own step tells of a lost torque: it goes at once, and k1 itself would be too late."""

# The supply is held until it moves by this: the noise of its measurement must not move the angle.
_SUPPLY_MOVED = 0.02
# Given back besides the step, so that the walk back does not end on the edge itself.
_RECOVERY = radians(0.3)
# Dwell times (s, in the drive's own time). The climb waits least: the load takes speed away faster than steps of a
# degree return it.
_STARVED_DWELL = 0.03
_DWELL = 0.02
_CLIMB_DWELL = 0.01
# Time in which lost speed has to come back, else the torque counts as lost (s).
_REGAIN = 0.25
# Of base speed (1/s).
_SLOWEST_REGAIN = 0.04
_LONGEST_CLIMB = radians(8.0)
_HEAVIER_THAN_HELD = 1.1


@inlined
def begin_settling(state: Any) -> None:
    """Start a new decision interval, and wait until the current sum repeats before the next move."""
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


@inlined
def rearm(state: Any) -> None:
    """Return to the initial angle and forget what was found: command or load has changed."""
    state.offset = 0.0
    state.step = state.first_step
    # The initial line keeps above the edge, so less current lies at less angle.
    state.direction = -1.0
    allow_all_angles(state)
    state.forbidden_power = 0.0
    state.retried = NOT_RETRIED
    state.good_integral = inf
    state.good_power = inf
    state.climb = 0.5 * state.first_step
    state.regained = -inf
    state.calm_error = inf
    state.confirmed = 0
    state.widened = 0
    state.reversals = 0
    state.jolted_at = inf
    state.lost_speed = inf
    state.initial_power = 0.0
    begin_settling(state)


@inlined
def take_step(state: Any, power: float, step: float) -> None:
    """Move the angle, and keep what a walk back returns to.

    Parameters
    ----------
    power : float
        Mean current sum at the present angle (A).
    step : float
        Angle to add (rad electrical).
    """
    state.moved = step
    state.good_offset = state.offset
    state.good_integral = state.integral
    state.good_power = power
    state.offset += step


@inlined
def walk_back(state: Any, angle: float, lost: bool) -> None:
    """Add angle, and forbid the present one where it has lost the torque.

    The walk starts from the search's own step toward less angle, leads back to the initial angle, and beyond
    it where even that one cannot give the torque.

    Parameters
    ----------
    angle : float
        Angle to add (rad electrical).
    lost : bool
        Whether torque is lost at the present angle, rather than too slow to return.
    """
    if lost:
        forbid(state)
    state.offset += angle
    # The edge is near; what comes next has to be smaller than what led over it.
    state.step = max(min(0.5 * state.step, 0.5 * state.first_step), SMALLEST_STEP)
    state.direction = -1.0
    begin_settling(state)


@inlined
def remember_lost_speed(state: Any, sag: float) -> None:
    """Keep the speed that was lost when a step was given back, where more is given back if it falls on.

    Parameters
    ----------
    sag : float
        Speed reference minus speed (rad/s).
    """
    state.lost_speed = sag if state.tries_again == 1 else inf


@inlined
def give_step_back(state: Any, angle: float) -> None:
    """Add angle after a step toward less of it that has crept over the edge, which lies somewhere in that step.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated; half of the step is forbidden.
    angle : float
        Angle to add, no less than the step (rad electrical).
    """
    half = -0.5 * state.moved
    state.offset += half
    walk_back(state, angle - half, True)
    remember_lost_speed(state, max(state.error, 0.0))


@inlined
def falls_on(state: Any, sag: float, period: float) -> bool:
    """Return whether as much speed again is lost, although the step that began to lose it was given back.

    Parameters
    ----------
    sag : float
        Speed reference minus speed (rad/s).
    period : float
        Control period in the drive's own time (s).

    Returns
    -------
    bool
        False as long as the angle that was given back has had no time to act.
    """
    falling: bool = sag > state.lost_speed + ALARM * state.speed_tolerance
    return falling and state.count * period >= _DWELL


@inlined
def walk_farther_back(state: Any, sag: float) -> None:
    """Give back more angle, since the speed falls on after the step that began to lose it was given back.

    Past the current of greatest torque more current reference gives less, so that the regulator would wind up where the
    angle has the torque in steady state.

    Parameters
    ----------
    sag : float
        Speed reference minus speed (rad/s).
    """
    state.integral = min(state.integral, state.good_integral)
    walk_back(state, max(state.first_step, min(-0.5 * state.offset, 2.0 * state.first_step)), True)
    state.lost_speed = sag


@inlined
def seek_torque(state: Any, gained: float) -> None:
    """Climb from the initial angle, which cannot give the torque, to one that can; in growing steps.

    Parameters
    ----------
    gained : float
        Speed gained at the current limit since the last step (rad/s).
    """
    # Past the angle of greatest torque each step returns less speed than the one before.
    if gained < state.regained:
        state.climb = -0.5 * state.climb
    # A heavy load takes the speed away meanwhile, so equal steps would come too late.
    elif abs(state.climb) < _LONGEST_CLIMB:
        state.climb = 2.0 * state.climb
    state.regained = gained
    # An angle at which speed returns, only slowly, has the torque and is not forbidden.
    walk_back(state, state.climb, gained <= 0.0 and state.climb > 0.0)


@inlined
def raise_angle(state: Any, gained: float, missing: float) -> None:
    """Add angle where a regulator at its limit does not return the speed.

    Parameters
    ----------
    gained : float
        Speed gained at the limit (rad/s).
    missing : float
        Speed reference minus speed (rad/s).
    """
    state.saturated_run = 0
    # Below the initial angle torque must return soon; at it, a heavy load may take its time to accelerate.
    required = missing * _DWELL / _REGAIN
    if state.offset >= 0.0:
        required = min(missing / _REGAIN, _SLOWEST_REGAIN * state.base_speed) * _CLIMB_DWELL
    if gained <= required and missing > 0.0:
        if state.offset < 0.0:
            walk_back(state, state.first_step, gained <= 0.0)
        else:
            seek_torque(state, gained)


@inlined
def guard_regulation(
    state: Any,
    speed: float,
    speed_reference: float,
    voltage: float,
    current_sum: float,
    reference: float,
    period: float,
) -> None:
    """Watch the regulator at every step and give the angle back when it costs regulation.

    Parameters
    ----------
    speed, speed_reference : float
        (rad/s).
    voltage : float
        Measured voltage of a half-source (V).
    current_sum : float
        Measured sum of the phase currents' magnitudes (A).
    reference : float
        Current reference (A).
    period : float
        Control period in the drive's own time (s).
    """
    # The edge depends on EMF over supply, so either one makes what was found worthless.
    supply_moved = abs(voltage - state.supply_voltage) > _SUPPLY_MOVED * state.nominal_voltage
    if speed_reference != state.speed_reference or supply_moved:
        state.speed_reference = speed_reference
        state.supply_voltage = voltage
        rearm(state)
    sag = speed_reference - speed
    if state.offset < 0.0 and sag > (1.0 if state.mode == HOLDING else 3.0) * state.speed_tolerance:
        # The load has grown, or the angle was below what it needs from the start; neither is to be tried again.
        held = state.mode == HOLDING
        forbid(state)
        forbidden = state.forbidden
        # An angle that was held gave the torque until then: what lost it is a load heavier than the one held.
        forbidden_power = (_HEAVIER_THAN_HELD if held else 1.0) * state.forbidden_power
        # Unless the load is the same: then what the current sum was at the initial angle shows there again.
        initial_power = state.initial_power if held else 0.0
        rearm(state)
        state.forbidden = forbidden
        # A fall as deep as this one is not to be had again.
        state.lost_at = forbidden
        state.retried = RETRIED
        state.forbidden_power = forbidden_power
        state.initial_power = initial_power
    state.saturated_run = state.saturated_run + 1 if reference >= state.current_limit else 0
    if state.saturated_run == 1:
        state.speed_mark = speed
    flowing = current_sum / state.conducting_phases
    # A reference far beyond the current shows a lost torque before the regulator reaches its limit.
    starved = reference > STARVED * flowing + SLACK * state.current_limit
    state.starved_run = state.starved_run + 1 if starved else 0
    if state.starved_run == 1:
        state.starved_mark = speed
    is_starved = state.starved_run * period >= _STARVED_DWELL
    # After an own step downward that step is to blame, so it is given back whole.
    if state.moved < 0.0 and (is_starved or speed_reference - speed > ALARM * state.speed_tolerance):
        # The integral has wound up in vain; with the old angle goes the old current.
        state.integral = state.good_integral
        walk_back(state, -state.moved + _RECOVERY, True)
        remember_lost_speed(state, sag)
    elif falls_on(state, sag, period):
        walk_farther_back(state, sag)
    elif is_starved and state.offset < 0.0:
        state.starved_run = 0
        gained = speed - state.starved_mark
        if gained <= sag * _STARVED_DWELL / _REGAIN:
            # Left at what it wound up in vain, the integral would overshoot once the torque is back.
            state.integral = min(state.integral, STARVED * flowing)
            walk_back(state, state.first_step, gained <= 0.0)
    elif state.saturated_run * period >= (_DWELL if state.offset < 0.0 else _CLIMB_DWELL):
        raise_angle(state, speed - state.speed_mark, sag)
