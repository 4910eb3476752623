"""Position of the shaft for field-oriented control: as measured, or extrapolated past a missing Hall edge."""

from __future__ import annotations

from math import isnan, nan, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.hall_observer import greatest_speed, observe_shaft
from drivegate_models.machine.cycle import within_half_turn

# Maximum extrapolation without an edge (rad electrical): a sector, in which the edge after the missing one appears,
# plus the placement errors of both.
_LED_ON: Final = 1.1 * pi / 3.0
# Minimum speed for extrapolation, relative to base speed: a slower shaft may come to rest within a sector.
_LEAST_SPEED: Final = 0.15
# Share of the expected rotation in a period below which the timer limits the angle at its sector's end.
_HELD_BACK: Final = 0.9


@inlined
def reset_position(state: Any, nameplate: Any, filter_rate: float) -> None:
    """Write the constants and reset the position.

    `filter_rate` is that of the filter of the seen speed (rad/s), infinite for none.
    """
    state.filter_share = 1.0 / (1.0 + 1.0 / (filter_rate * nameplate.control_period))
    state.filtered_speed = nan
    state.led_on_longest = _LED_ON
    state.led_on_from = _LEAST_SPEED * nameplate.base_speed
    state.led_on = 0.0
    state.hall_before = -1
    state.hall_angle = 0.0
    state.hall_speed = 0.0
    state.is_overdue = 0
    state.direct_seen = 0.0
    state.quadrature_voltage = 0.0
    state.quadrature_seen = 0.0
    state.quadrature_before = 0.0


@inlined
def locate_shaft(state: Any, sense: Any) -> Any:
    """Return the Sense in use: the measured one, with the shaft's angle and speed extrapolated at an overdue Hall edge.

    With Hall switches it is the state's record `seen`, otherwise `sense` itself. A timer of Hall edges limits its
    angle to the sector's end until the next edge, and reduces its speed. At a high speed, a lost edge is more
    likely than a stop, so the angle is extrapolated with the last speed for one more sector. Without an edge until
    then, the measured values are used. In speed control, an observer provides angle and speed between the edges.
    """
    if sense.hall < 0:
        return sense
    state.seen = sense
    seen = state.seen
    if state.regulates_speed == 1:
        observe_shaft(state, sense, seen)
        return seen
    turned = within_half_turn(state.pole_pairs * (sense.angle - state.hall_angle))
    # Both as angles in the sense of rotation.
    sense_of_rotation = 1.0 if state.hall_speed >= 0.0 else -1.0
    turned *= sense_of_rotation
    absolute_speed = abs(state.hall_speed)
    expected = state.pole_pairs * absolute_speed * state.control_period
    has_come = sense.hall != state.hall_before
    state.hall_before = sense.hall
    state.hall_angle = sense.angle
    if has_come:
        state.hall_speed = sense.speed
    was_led_on = state.led_on > 0.0
    state.is_overdue = 0
    if has_come or turned >= _HELD_BACK * expected:
        state.led_on = 0.0
    elif absolute_speed >= state.led_on_from and state.led_on + expected <= state.led_on_longest:
        state.led_on += expected - turned
        seen.angle = sense.angle + sense_of_rotation * state.led_on / state.pole_pairs
        seen.speed = state.hall_speed
    elif was_led_on:
        state.is_overdue = 1
    return seen


@inlined
def regulated_speed(state: Any, seen: Any, timed: float) -> float:
    """Return the speed for the regulator (rad/s).

    That of Hall switches is limited to a sector over the time since the last edge. Any other one, `timed` (rad/s), is
    filtered, because it swings within a turn with the errors of the sensor.
    """
    if seen.hall < 0:
        before = timed if isnan(state.filtered_speed) else state.filtered_speed
        state.filtered_speed = before + state.filter_share * (timed - before)
        return float(state.filtered_speed)
    most = greatest_speed(state)
    return float(min(max(seen.speed, -most), most))
