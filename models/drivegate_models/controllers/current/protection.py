"""Protection of speed regulation during a search for the advance angle, for any search.

It settles before the search begins, reverts an angle that has lost the torque, looks for an angle that provides it, and
restarts when command, supply or load has changed.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.forbidden_angle import forbid
from drivegate_models.controllers.current.modes import (
    begin_following,
    begin_settling,
    may_follow,
    rearm,
    stop_following,
)
from drivegate_models.controllers.current.state import (
    FOLLOWING,
    HOLDING,
    RETRIED,
    SMALLEST_STEP,
)
from drivegate_models.controllers.current.unrest import JOLT

STARVED: Final = 3.0
"""Multiple of the actual current beyond which the current reference indicates a starved winding."""
SLACK: Final = 0.04
"""Excess of the current reference that does not yet indicate a starved winding, as a share of the current limit."""
ALARM: Final = 0.3
"""Share of k1: a larger loss of speed after a step indicates lost torque, unless the speed regulator is slow.

Waiting for k1 itself would be too late.
"""

# Share of rated current by which the current reference may have to rise at a smaller angle that provides the torque.
_RISE = 0.06
# The stored supply voltage changes only by more than this: measurement noise must not move the angle.
_SUPPLY_MOVED = 0.02
# Reverted in addition to the step, so that the angle does not end on the edge itself.
_RECOVERY = radians(0.3)
# Dwell times (s, scaled by the drive's electrical frequency). The climb waits least: the load takes speed away
# faster than one-degree steps return it.
_STARVED_DWELL = 0.03
_DWELL = 0.02
_CLIMB_DWELL = 0.01
# Time in which lost speed must return; otherwise the torque counts as lost (s).
_REGAIN = 0.25
# Minimum acceleration, as a share of base speed (1/s).
_SLOWEST_REGAIN = 0.04
_LONGEST_CLIMB = radians(8.0)
_HEAVIER_THAN_HELD = 1.1


@inlined
def alarming_sag(state: Any) -> float:
    """Return the loss of speed (rad/s) that indicates lost torque after a step.

    A slow regulator loses more than `ALARM` of k1 until it has found a higher current reference.
    """
    until_found = _RISE * state.rated_sum / (state.conducting_phases * state.proportional)
    sag: float = min(max(ALARM * state.speed_tolerance, until_found), JOLT * state.speed_tolerance)
    return sag


@inlined
def take_step(state: Any, current_sum: float, step: float) -> None:
    """Add `step` to the angle (rad electrical), and store the state to which it can be reverted.

    `current_sum` is the mean at the present angle (A).
    """
    state.moved = step
    state.good_offset = state.offset
    state.good_integral = state.integral
    state.good_power = current_sum
    state.offset += step


@inlined
def back_off(state: Any, angle: float, lost: bool) -> None:
    """Add `angle` (rad electrical), and forbid the present angle if it has lost the torque.

    It reverts the search's own steps toward less angle, leads back to the initial angle, and beyond it if even that one
    cannot provide the torque. `lost` is False if the torque only returns too slowly.
    """
    if lost:
        forbid(state)
    state.offset += angle
    # A search upward that has taken no step yet keeps its direction.
    begins_upward = state.compared == 1 and state.good_power == inf
    if not begins_upward:
        # The edge is near; the next step must be smaller than the one that led over it.
        state.step = max(min(0.5 * state.step, 0.5 * state.first_step), SMALLEST_STEP)
        state.direction = -1.0
    begin_settling(state)
    if lost and may_follow(state):
        begin_following(state)


@inlined
def record_lost_speed(state: Any, sag: float) -> None:
    """Store the lost speed (rad/s) when a step is reverted; more angle is reverted if the speed keeps falling."""
    state.lost_speed = sag if state.tries_again == 1 else inf


@inlined
def revert_step(state: Any, angle: float) -> None:
    """Add `angle` (rad electrical, at least the last step) after a step toward less angle that crept over the edge.

    The edge lies somewhere in that step, so half of it is forbidden.
    """
    half = -0.5 * state.moved
    state.offset += half
    back_off(state, angle - half, True)
    record_lost_speed(state, max(state.error, 0.0))


@inlined
def is_still_falling(state: Any, sag: float, period: float) -> bool:
    """Return True if as much speed again is lost, although the step that began to lose it was reverted.

    `sag` is speed reference minus speed (rad/s) and `period` the scaled control period (s). False until the
    reverted angle has had time to act.
    """
    falling: bool = sag > state.lost_speed + alarming_sag(state)
    return falling and state.count * period >= _DWELL


@inlined
def back_off_farther(state: Any, sag: float) -> None:
    """Revert more angle, because the speed keeps falling after the step that began to lose it was reverted.

    Beyond the current of maximum torque, more current reference produces less torque. The regulator would wind up at an
    angle that provides the torque in steady state. `sag` is speed reference minus speed (rad/s).
    """
    state.integral = min(state.integral, state.good_integral)
    back_off(state, max(state.first_step, min(-0.5 * state.offset, 2.0 * state.first_step)), True)
    state.lost_speed = sag


@inlined
def seek_torque(state: Any, gained: float) -> None:
    """Climb in growing steps from the initial angle, which cannot provide the torque, to one that can.

    `gained` is the speed gained at the current limit since the last step (rad/s).
    """
    # Beyond the angle of maximum torque, each step returns less speed than the preceding one.
    if gained < state.regained:
        state.climb = -0.5 * state.climb
    # A heavy load reduces the speed meanwhile, so equal steps would be too late.
    elif abs(state.climb) < _LONGEST_CLIMB:
        state.climb = 2.0 * state.climb
    state.regained = gained
    # An angle at which speed returns slowly provides the torque and is not forbidden.
    back_off(state, state.climb, gained <= 0.0 and state.climb > 0.0)


@inlined
def raise_angle(state: Any, gained: float, missing: float) -> None:
    """Add angle if a regulator at its limit does not return the speed.

    `gained` is the speed gained at the limit and `missing` speed reference minus speed (rad/s).
    """
    state.saturated_run = 0
    # Below the initial angle torque must return soon; at it, a heavy load may need longer to accelerate.
    required = missing * _DWELL / _REGAIN
    if state.offset >= 0.0:
        required = min(missing / _REGAIN, _SLOWEST_REGAIN * state.base_speed) * _CLIMB_DWELL
    if gained <= required and missing > 0.0:
        if state.offset < 0.0:
            back_off(state, state.first_step, gained <= 0.0)
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
    """Monitor the regulator in every control period, and revert angle that costs regulation.

    Speeds are in rad/s, `voltage` is the measured voltage of a half-source (V), `current_sum` the measured sum of
    the phase currents' magnitudes and `reference` the current reference (both A). `period` is the scaled control
    period (s).
    """
    # The edge depends on EMF over supply, so a change of either one invalidates the findings.
    supply_moved = abs(voltage - state.supply_voltage) > _SUPPLY_MOVED * state.nominal_voltage
    if speed_reference != state.speed_reference or supply_moved:
        state.speed_reference = speed_reference
        state.supply_voltage = voltage
        rearm(state)
    sag = speed_reference - speed
    if state.mode == FOLLOWING:
        # A single wrong reading of the speed must not end it.
        state.starved_run = state.starved_run + 1 if sag > 3.0 * state.speed_tolerance else 0
        if state.starved_run * period >= _DWELL:
            # Under this load the angle cannot hold the speed, so the search keeps off the edge instead.
            stop_following(state, current_sum, False)
        return
    if state.offset < 0.0 and sag > (1.0 if state.mode == HOLDING else 3.0) * state.speed_tolerance:
        # The load has grown, or the angle was too small for it from the start; in both cases do not try it again.
        held = state.mode == HOLDING
        forbid(state)
        forbidden = state.forbidden
        # An angle that was held provided the torque until then, so the load has become heavier.
        forbidden_power = (_HEAVIER_THAN_HELD if held else 1.0) * state.forbidden_power
        # Unless the load is the same: then the current sum at the initial angle is the same as before.
        initial_power = state.initial_power if held else 0.0
        rearm(state)
        state.forbidden = forbidden
        # Do not risk another loss of speed as deep as this one.
        state.lost_at = forbidden
        state.retried = RETRIED
        state.forbidden_power = forbidden_power
        state.initial_power = initial_power
    state.saturated_run = state.saturated_run + 1 if reference >= state.current_limit else 0
    if state.saturated_run == 1:
        state.speed_mark = speed
    flowing = current_sum / state.conducting_phases
    # A reference far beyond the actual current indicates lost torque before the regulator reaches its limit.
    starved = reference > STARVED * flowing + SLACK * state.current_limit
    state.starved_run = state.starved_run + 1 if starved else 0
    if state.starved_run == 1:
        state.starved_mark = speed
    is_starved = state.starved_run * period >= _STARVED_DWELL
    # After a step toward less angle, that step is the cause, so it is reverted completely.
    if state.moved < 0.0 and (is_starved or sag > alarming_sag(state)):
        # The integral has wound up in vain; the old angle needs the old current.
        state.integral = state.good_integral
        back_off(state, -state.moved + _RECOVERY, True)
        record_lost_speed(state, sag)
    elif is_still_falling(state, sag, period):
        back_off_farther(state, sag)
    elif is_starved and state.offset < 0.0:
        state.starved_run = 0
        gained = speed - state.starved_mark
        if gained <= sag * _STARVED_DWELL / _REGAIN:
            # A wound-up integral would make the speed overshoot once the torque is back.
            state.integral = min(state.integral, STARVED * flowing)
            back_off(state, state.first_step, gained <= 0.0)
    elif state.saturated_run * period >= (_DWELL if state.offset < 0.0 else _CLIMB_DWELL):
        raise_angle(state, speed - state.speed_mark, sag)
