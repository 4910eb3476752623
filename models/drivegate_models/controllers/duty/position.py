"""Where field-oriented control takes the shaft to be: as it is sensed, and on past a Hall edge that does not come."""

from __future__ import annotations

from math import floor, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.hall_observer import greatest_speed, observe_shaft

# Angle for which the shaft is led on without an edge: a sector, in which the next but one comes, and what the two may
# be out of place (rad electrical).
_LED_ON: Final = 1.1 * pi / 3.0
# Least speed over base speed: a slower shaft may come to rest within a sector.
_LEAST_SPEED: Final = 0.15
# Share of the way of a period below which the angle is held back at its sector's end.
_HELD_BACK: Final = 0.9

_TURN = 2.0 * pi


@inlined
def reset_position(state: Any, nameplate: Any) -> None:
    """Write the constants and forget where the shaft was."""
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
def copy_sense(sense: Any, seen: Any) -> None:
    """Copy what is sensed into another record of DUTY_SENSE."""
    seen.struct_size = sense.struct_size
    seen.time = sense.time
    seen.reference = sense.reference
    seen.phase_currents = sense.phase_currents
    seen.supply_voltage = sense.supply_voltage
    seen.supply_current = sense.supply_current
    seen.angle = sense.angle
    seen.speed = sense.speed
    seen.hall = sense.hall
    seen.encoder_count = sense.encoder_count
    seen.trip = sense.trip


@inlined
def see_shaft(state: Any, sense: Any) -> Any:
    """Return what the controller goes by: what is sensed, but for the shaft where a Hall edge is overdue.

    Parameters
    ----------
    state : record of FOC_STATE
        Its `seen` is written where Hall switches show the shaft.

    Returns
    -------
    record of DUTY_SENSE
        `seen`, or else `sense` itself.

    Notes
    -----
    A timer of Hall edges holds its angle at the sector's end until the next edge has come, and lets its speed fall.
    Where the speed was high, a shaft that turns on is likelier than one that stops: for a sector more its angle goes on
    with the speed that it had. If still no edge has come then, it is as sensed. Where a speed is requested of the shaft
    an observer shows it between the edges.
    """
    if sense.hall < 0:
        return sense
    seen = state.seen
    copy_sense(sense, seen)
    if state.regulates_speed == 1:
        observe_shaft(state, sense, seen)
        return seen
    turned = state.pole_pairs * (sense.angle - state.hall_angle)
    turned -= _TURN * floor(turned / _TURN + 0.5)
    expected = state.pole_pairs * state.hall_speed * state.control_period
    has_come = sense.hall != state.hall_before
    state.hall_before = sense.hall
    state.hall_angle = sense.angle
    if has_come:
        state.hall_speed = sense.speed
    was_led_on = state.led_on > 0.0
    state.is_overdue = 0
    if has_come or turned >= _HELD_BACK * expected:
        state.led_on = 0.0
    elif state.hall_speed >= state.led_on_from and state.led_on + expected <= state.led_on_longest:
        state.led_on += expected - turned
        seen.angle = sense.angle + state.led_on / state.pole_pairs
        seen.speed = state.hall_speed
    elif was_led_on:
        state.is_overdue = 1
    return seen


@inlined
def regulated_speed(state: Any, seen: Any, timed: float) -> float:
    """Return the speed that is regulated (rad/s): no more than a sector over the time without a Hall edge."""
    if seen.hall < 0:
        return timed
    most = greatest_speed(state)
    return float(min(max(seen.speed, -most), most))
