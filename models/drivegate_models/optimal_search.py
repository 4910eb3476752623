"""The on-line search for the advance angle of least input power (paper, Fig. 4), literal and guarded.

Input power is judged by the current sum, which is proportional to the power exchanged with the supply
("Optimal Efficiency Control").
"""

from __future__ import annotations

from math import inf, pi, radians
from typing import Any, Final

from drivegate_models.compilation import unfused

SETTLING: Final = 0
"""Mode: command or load has changed; wait until the current sum repeats."""
SEARCHING: Final = 1
"""Mode: each decision moves the angle."""
HOLDING: Final = 2
"""Mode: the optimum is found; wait for a change."""

_SETTLED = 0.01
_CHANGED = 0.03
_LOAD_CHANGED = 0.12
_SUPPLY_MOVED = 0.02
_SMALLEST_STEP = radians(0.24)
_MARGIN = radians(0.2)
_RECOVERY = radians(0.3)
_SMALLEST_POWER = 1.0
_ALARM = 0.3
_UNEASY = 0.1
_CALM = 1.5
_ANSWER = 2.0
_CREEP = 1.15
_CREEP_LEAST = 0.15
_IMPROVEMENTS = 3
_RESTLESS = 0.003
_LIGHTER = 0.88
_HEAVIER = 1.35
_WINDING = 0.005
_IDLE = 0.002
_WOUND = 3
_STARVED = 3.0
_SLACK = 0.04
_STARVED_DWELL = 0.03
_DWELL = 0.02
_CLIMB_DWELL = 0.01
_REGAIN = 0.25
_SLOWEST_REGAIN = 20.0 * pi / 30.0
_LONGEST_CLIMB = radians(8.0)


@unfused
def decide_by_flowchart(state: Any, error: float) -> None:
    """Make one decision of Fig. 4, literally: gate by k1, stop by k2, reverse or go on.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    error : float
        Speed reference minus speed at the decision (rad/s).
    """
    power = state.power_sum / state.count
    if abs(error) > state.speed_tolerance:
        return
    change = power - state.old_power
    state.old_power = power
    if abs(change) <= state.power_tolerance * power:
        return
    if change > 0.0:
        state.direction = -state.direction
    state.offset += state.direction * state.step


@unfused
def begin_settling(state: Any) -> None:
    """Start a new decision interval, and wait until the current sum repeats before the next move.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    """
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


@unfused
def rearm(state: Any) -> None:
    """Return to the initial angle and forget what was found: command or load has changed.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    """
    state.offset = 0.0
    state.step = state.first_step
    state.direction = -1.0
    state.forbidden = -inf
    state.forbidden_power = 0.0
    state.good_integral = inf
    state.good_power = inf
    state.climb = 0.5 * state.first_step
    state.regained = -inf
    state.calm_error = inf
    begin_settling(state)


@unfused
def forbid(state: Any) -> None:
    """Forbid the present angle and those below it, for a load as heavy as the present one.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    """
    state.forbidden = max(state.forbidden, state.offset)
    # What has been held is known better than the interval in which it was lost.
    state.forbidden_power = state.held_power if state.mode == HOLDING else state.last_power


@unfused
def walk_back(state: Any, angle: float, lost: bool) -> None:
    """Add angle, and forbid the present one where it has lost the torque.

    The walk starts from the search's own step toward less angle, leads back to the initial angle, and beyond
    it where even that one cannot give the torque.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    angle : float
        Angle to add (rad electrical).
    lost : bool
        Whether torque is lost at the present angle, rather than too slow to return.
    """
    if lost:
        forbid(state)
    state.offset += angle
    state.step = max(min(0.5 * state.step, 0.5 * state.first_step), _SMALLEST_STEP)
    state.direction = -1.0
    begin_settling(state)


@unfused
def seek_torque(state: Any, gained: float) -> None:
    """Climb from the initial angle, which cannot give the torque, to one that can; in growing steps.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    gained : float
        Speed gained at the current limit since the last step (rad/s).
    """
    if gained < state.regained:
        state.climb = -0.5 * state.climb
    elif abs(state.climb) < _LONGEST_CLIMB:
        state.climb = 2.0 * state.climb
    state.regained = gained
    walk_back(state, state.climb, gained <= 0.0 and state.climb > 0.0)


@unfused
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
    state : record of CONTROLLER_STATE
        Updated.
    speed, speed_reference : float
        (rad/s).
    voltage : float
        Measured voltage of a half-source (V).
    current_sum : float
        Measured sum of the phase currents' magnitudes (A).
    reference : float
        Current reference (A).
    period : float
        Control period (s).
    """
    supply_moved = abs(voltage - state.supply_voltage) > _SUPPLY_MOVED * state.nominal_voltage
    if speed_reference != state.speed_reference or supply_moved:
        state.speed_reference = speed_reference
        state.supply_voltage = voltage
        rearm(state)
    sag = speed_reference - speed
    if state.offset < 0.0 and sag > (1.0 if state.mode == HOLDING else 3.0) * state.speed_tolerance:
        # The load has grown, or the angle was below what it needs from the start; neither is to be tried again.
        forbid(state)
        forbidden = state.forbidden
        forbidden_power = state.forbidden_power
        rearm(state)
        state.forbidden = forbidden
        state.forbidden_power = forbidden_power
    state.saturated_run = state.saturated_run + 1 if reference >= state.current_limit else 0
    if state.saturated_run == 1:
        state.speed_mark = speed
    flowing = current_sum / state.conducting_phases
    starved = reference > _STARVED * flowing + _SLACK * state.current_limit
    state.starved_run = state.starved_run + 1 if starved else 0
    if state.starved_run == 1:
        state.starved_mark = speed
    is_starved = state.starved_run * period >= _STARVED_DWELL
    if state.moved < 0.0 and (is_starved or speed_reference - speed > _ALARM * state.speed_tolerance):
        # The integral has wound up in vain; with the old angle goes the old current.
        state.integral = state.good_integral
        walk_back(state, -state.moved + _RECOVERY, True)
    elif is_starved and state.offset < 0.0:
        state.starved_run = 0
        gained = speed - state.starved_mark
        if gained <= sag * _STARVED_DWELL / _REGAIN:
            state.integral = min(state.integral, _STARVED * flowing)
            walk_back(state, state.first_step, gained <= 0.0)
    elif state.saturated_run * period >= (_DWELL if state.offset < 0.0 else _CLIMB_DWELL):
        state.saturated_run = 0
        gained = speed - state.speed_mark
        missing = speed_reference - speed
        # Below the initial angle torque must return soon; at it, a heavy load may take its time to accelerate.
        wanted = missing * _DWELL / _REGAIN
        if state.offset >= 0.0:
            wanted = min(missing / _REGAIN, _SLOWEST_REGAIN) * _CLIMB_DWELL
        if gained <= wanted and missing > 0.0:
            if state.offset < 0.0:
                walk_back(state, state.first_step, gained <= 0.0)
            else:
                seek_torque(state, gained)


@unfused
def begin_holding(state: Any, power: float) -> None:
    """Rest at the angle found.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power : float
        Current sum found there (A).
    """
    state.mode = HOLDING
    state.held_power = power
    if state.good_power == inf:
        state.good_offset = state.offset
        state.good_integral = state.integral
        state.good_power = power
    state.moved = 0.0
    state.quiet = 0


@unfused
def is_uneasy(state: Any) -> bool:
    """Return whether the speed varied by more than sensors and regulator explain.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state; the calmest decision interval since the last change tells what they explain.

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    uneasy: bool = state.worst_error > _UNEASY * state.speed_tolerance + _CALM * state.calm_error
    return uneasy


@unfused
def noise_of_power(state: Any) -> float:
    """Return what the converter, and the regulator's answer to the speed sensor's errors, make of the power.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.

    Returns
    -------
    float
        Current sum (A).
    """
    error = min(state.calm_error, _UNEASY * state.speed_tolerance)
    noise: float = state.least_change + _ANSWER * state.proportional * error
    return noise


@unfused
def is_creeping(state: Any, power: float) -> bool:
    """Return whether the regulator winds up in vain: more current reference for no more current.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, with what was needed at the last good angle.
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        False as long as no good angle is known, and well above it.
    """
    near = state.offset < state.good_offset + state.first_step
    creeping: bool = (
        near
        and state.integral > _CREEP * state.good_integral + _CREEP_LEAST
        and power < (1.0 + 0.5 * _CHANGED) * state.good_power
    )
    return creeping


@unfused
def load_has_changed(state: Any, power: float) -> bool:
    """Return whether the current sum differs from that of the last good angle by more than angles explain.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        False as long as no good angle is known, and away from it.
    """
    near = abs(state.offset - state.good_offset) <= 3.0 * state.first_step
    changed: bool = near and abs(power - state.good_power) > _LOAD_CHANGED * power + 0.2
    return changed and state.good_power < inf


@unfused
def decide_holding(state: Any, power: float, change: float) -> None:
    """Watch what was found: search anew after a change of load, and keep off an edge that is too near.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    """
    uneasy = is_uneasy(state)
    changed = abs(power - state.held_power) > _CHANGED * power + 0.2
    if is_creeping(state, power):
        state.integral = state.good_integral
        walk_back(state, state.first_step if uneasy else _SMALLEST_STEP, True)
    elif state.quiet == 0:
        # The interval of its own last step is not judged.
        state.quiet = 1
        if not changed:
            state.held_power = power
    elif changed:
        rearm(state)
    elif uneasy or abs(change) > _RESTLESS * power + noise_of_power(state):
        forbid(state)
        state.offset += _SMALLEST_STEP
        state.quiet = 0


@unfused
def move(state: Any, power: float, change: float) -> None:
    """Take the next step, by as much as the forbidden angle leaves; rest where nothing is left.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    """
    if power < _LIGHTER * state.forbidden_power or power > _HEAVIER * state.forbidden_power:
        # A lighter load has a lower edge; and a load that has become much heavier costs speed at any angle.
        state.forbidden = -inf
    while (
        state.step >= _SMALLEST_STEP
        and state.direction < 0.0
        and state.offset - state.step < state.forbidden + _MARGIN
    ):
        state.step = 0.5 * state.step
    if state.step < _SMALLEST_STEP:
        if change > 0.0 and state.moved != 0.0:
            # The last step made things worse: it is taken back before the search rests.
            state.offset -= state.moved
        begin_holding(state, power)
        return
    state.moved = state.direction * state.step
    state.good_offset = state.offset
    state.good_integral = state.integral
    state.good_power = power
    state.offset += state.moved


@unfused
def decide_guarded(state: Any) -> None:
    """Make one decision of the guarded search.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated; its decision interval is complete.
    """
    power = state.power_sum / state.count
    state.calm_error = min(state.calm_error, state.worst_error)
    winding = state.integral - state.last_integral > _WINDING * state.current_limit
    winding = winding and abs(power - state.last_power) < _IDLE * power
    state.winding = state.winding + 1 if winding else 0
    state.last_integral = state.integral
    state.last_power = power
    regulated = state.worst_error <= state.speed_tolerance and state.saturated == 0
    change = power - state.old_power
    state.old_power = power
    if state.mode == HOLDING:
        decide_holding(state, power, change)
        return
    if state.winding >= _WOUND and is_uneasy(state):
        # The reference is beyond what the angle lets flow; without a good angle known, the current tells it.
        state.integral = min(state.integral, power / state.conducting_phases)
        walk_back(state, state.first_step, True)
        return
    if is_creeping(state, power) and is_uneasy(state):
        state.integral = state.good_integral
        walk_back(state, 0.5 * state.first_step, True)
        return
    if not regulated or power < _SMALLEST_POWER:
        begin_settling(state)
        return
    settled = abs(change) <= _SETTLED * power
    if (settled or state.mode != SETTLING) and load_has_changed(state, power):
        rearm(state)
        return
    if state.mode == SETTLING:
        wound = state.integral > _STARVED * power / state.conducting_phases + _SLACK * state.current_limit
        if not settled or wound or is_uneasy(state):
            return
        state.mode = SEARCHING
        state.climb = 0.5 * state.first_step
        state.regained = -inf
    elif abs(change) <= max(state.power_tolerance * power, noise_of_power(state)):
        state.quiet += 1
        if state.quiet >= 2:
            begin_holding(state, power)
            return
    else:
        state.quiet = 0
        state.improvements += 1
        if change > 0.0:
            state.direction = -state.direction
            state.step = 0.5 * state.step
            state.improvements = 0
        elif state.improvements >= _IMPROVEMENTS and state.step < 2.0 * state.first_step:
            state.step = 2.0 * state.step
            state.improvements = 0
    move(state, power, change)
