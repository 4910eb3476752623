"""Observer of angle, speed and load between two Hall edges, for speed control.

The timer's speed is the mean of the last electrical cycle. At low speed this delay is too long for the speed regulator.
An observer uses the motor's torque, and needs edges only for the unknown load.
"""

from __future__ import annotations

from math import floor, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn

# Rate of the observer relative to the bandwidth of the speed regulator, which it must exceed by far.
_RATE: Final = 10.0

_TURN = 2.0 * pi
_SECTOR = pi / 3.0
_FIRST_EDGE = pi / 6.0
_SECTORS = 6


@inlined
def reset_observer(state: Any, speed_bandwidth: float, inertia: float) -> None:
    """Write the constants and reset the shaft's state.

    `speed_bandwidth` is that of the speed regulator (rad/s), `inertia` that of the shaft (kg m²).
    """
    state.observer_rate = _RATE * speed_bandwidth
    state.inertia = inertia
    state.sector = -1
    state.is_placed = 0
    state.since_edge = 0.0
    state.place = 0.0
    state.turned_on = 0.0
    state.rate = 0.0
    state.edge_rate = 0.0
    state.slowing = 0.0
    state.seen_torque = 0.0


@inlined
def _sector_of(electrical: float) -> int:
    """Return the number of the sector, 0 to 5, of the timer's angle (rad electrical)."""
    place = electrical - _FIRST_EDGE
    return min(int((place - _TURN * floor(place / _TURN)) / _SECTOR), _SECTORS - 1)


@inlined
def _begin(state: Any, electrical: float, rate: float, sector: int) -> None:
    """Start from the timer's values: the angle of a turning shaft, or an unknown angle in the sector at rest."""
    state.sector = sector
    state.is_placed = 0 if rate == 0.0 else 1
    state.since_edge = 0.0
    state.place = electrical
    state.turned_on = 0.0
    state.rate = rate
    state.edge_rate = rate
    state.slowing = 0.0


@inlined
def _bound_rate(state: Any) -> None:
    """Limit the speed at an edge to the maximum for the time in the sector, and attribute the difference to the load.

    With constant acceleration from rest, a shaft leaves a whole sector at twice its mean speed. If it starts within the
    sector, half of it remains on average.
    """
    mean = _SECTOR / state.since_edge
    most = 2.0 * mean if state.is_placed == 1 else mean
    bounded = min(max(state.rate, -most), most)
    state.slowing += (state.rate - bounded) / state.since_edge
    state.rate = bounded


@inlined
def _correct(state: Any, electrical: float, rate: float, sector: int, passed: int) -> None:
    """Set the shaft to the place of an edge, and attribute the error of its prediction to speed and load.

    Errors of speed and acceleration shrink by ``p = 1 / (1 + r t)`` over each interval ``t``. The corrections are
    ``(2 q - q² / 2) e / t`` and ``q² e / t²``, with ``q = 1 - p`` and the error ``e`` of the angle.
    """
    period = state.control_period
    if rate * passed > 0.0:
        place = electrical
    else:
        # After a restart, the timer shows the sector's middle.
        entered = sector if passed > 0 else sector + 1
        place = _FIRST_EDGE + _SECTOR * entered + 0.5 * period * state.rate
    travelled = within_half_turn(place - state.place)
    if state.is_placed == 1:
        error = travelled - state.turned_on
        share = state.observer_rate / (1.0 + state.observer_rate * state.since_edge)
        state.rate += share * (2.0 - 0.5 * share * state.since_edge) * error
        state.slowing -= share * share * error
    _bound_rate(state)
    state.is_placed = 1
    state.sector = sector
    state.since_edge = 0.0
    state.place = place
    state.turned_on = 0.0
    state.edge_rate = state.rate


@inlined
def greatest_speed(state: Any) -> float:
    """Return the maximum mean speed of a shaft that has passed no edge since the last one (rad/s)."""
    return float(_SECTOR / (state.pole_pairs * max(state.since_edge, state.control_period)))


@inlined
def observe_shaft(state: Any, sense: Any, seen: Any) -> None:
    """Write angle and speed of the shaft into `seen`, from the timer's values in `sense`.

    At an overdue edge and above a minimum speed, the angle is extrapolated past the edge's place, because a lost
    edge is more likely than a stop, unless the shaft has turned round. Otherwise the speed is limited to a sector over
    the time since the last edge, and the angle returns to the middle of the sector, with an error of at most half a
    sector.
    """
    period, pairs = state.control_period, state.pole_pairs
    electrical, timed = pairs * sense.angle, pairs * sense.speed
    sector = _sector_of(electrical)
    state.is_overdue = 0
    if state.sector < 0:
        _begin(state, electrical, timed, sector)
        return
    gained = (pairs * state.seen_torque / state.inertia - state.slowing) * period
    state.turned_on += (state.rate + 0.5 * gained) * period
    state.rate += gained
    state.since_edge += period
    passed = (sector - state.sector + 8) % _SECTORS - 2
    if passed != 0:
        _correct(state, electrical, timed, sector, passed)
    begin = within_half_turn(_FIRST_EDGE + _SECTOR * state.sector - state.place)
    inside = min(max(state.turned_on, begin), begin + _SECTOR)
    rate = state.rate
    was_led_on = state.led_on > 0.0
    state.led_on = abs(state.turned_on - inside)
    if state.led_on > 0.0:
        # A shaft that has turned round since its last edge returns as late as a load that opposes its rotation lets it.
        turns_on = state.rate * state.edge_rate > 0.0
        is_fast = abs(state.edge_rate) >= pairs * state.led_on_from
        if turns_on and is_fast and state.led_on <= state.led_on_longest:
            inside = state.turned_on
        else:
            state.is_overdue = 1 if was_led_on and turns_on else 0
            # The longer there is no edge, the more likely the shaft has stopped somewhere in its sector.
            middle = begin + 0.5 * _SECTOR
            inside = middle + (inside - middle) * max(1.0 - 2.0 * state.led_on / _SECTOR, 0.0)
            state.led_on = 0.0
            most = pairs * greatest_speed(state)
            rate = min(max(rate, -most), most)
    if state.is_placed == 0:
        # The initial place of the shaft in its sector is unknown.
        inside = begin + 0.5 * _SECTOR
    seen.angle = (state.place + inside) / pairs
    seen.speed = rate / pairs
