"""A shaft that a speed is requested of, between two Hall edges: angle, speed and load by an observer.

The timer's speed is the mean of the last electrical cycle, which at low speed is older than the speed regulator can
bear. An observer knows the motor's own torque and needs edges only for what it does not know: the load.
"""

from __future__ import annotations

from math import floor, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined

# Rate of the observer over the bandwidth of the speed, well above which it has to be.
_RATE: Final = 10.0

_TURN = 2.0 * pi
_SECTOR = pi / 3.0
_FIRST_EDGE = pi / 6.0
_SECTORS = 6


@inlined
def reset_observer(state: Any, speed_bandwidth: float, inertia: float) -> None:
    """Write the constants and forget the shaft.

    Parameters
    ----------
    state : record of FOC_STATE
        Receives them.
    speed_bandwidth : float
        Of the speed regulator (rad/s).
    inertia : float
        Of the shaft (kg m²).
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
    """Return the number of the sector that an angle of the timer lies in, 0 to 5."""
    place = electrical - _FIRST_EDGE
    return min(int((place - _TURN * floor(place / _TURN)) / _SECTOR), _SECTORS - 1)


@inlined
def _begin(state: Any, electrical: float, rate: float, sector: int) -> None:
    """Start from what the timer shows: a turning shaft is in its place, one at rest somewhere in its sector."""
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
    """Limit the speed at an edge to what a shaft can have that took so long for its sector, and blame the load.

    One that speeds up evenly from rest leaves a whole sector at twice its mean speed, and one that starts somewhere in
    it has half of it to go on average.
    """
    mean = _SECTOR / state.since_edge
    most = 2.0 * mean if state.is_placed == 1 else mean
    bounded = min(max(state.rate, -most), most)
    state.slowing += (state.rate - bounded) / state.since_edge
    state.rate = bounded


@inlined
def _correct(state: Any, electrical: float, rate: float, sector: int, passed: int) -> None:
    """Take the place of an edge for the shaft's, and the error of its expectation for one of speed and load.

    Notes
    -----
    Errors of speed and acceleration shrink by ``p = 1 / (1 + r t)`` over each interval ``t``: the corrections are
    ``(2 q - q² / 2) e / t`` and ``q² e / t²``, with ``q = 1 - p`` and the error ``e`` of the angle.
    """
    period = state.control_period
    if rate * passed > 0.0:
        place = electrical
    else:
        # A timer that starts again shows the sector's middle.
        entered = sector if passed > 0 else sector + 1
        place = _FIRST_EDGE + _SECTOR * entered + 0.5 * period * state.rate
    travelled = place - state.place
    travelled -= _TURN * floor(travelled / _TURN + 0.5)
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
    """Return the greatest mean speed of a shaft that has passed no edge since the last one (rad/s)."""
    return float(_SECTOR / (state.pole_pairs * max(state.since_edge, state.control_period)))


@inlined
def observe_shaft(state: Any, sense: Any, seen: Any) -> None:
    """Write where the shaft is, and how fast.

    Parameters
    ----------
    state : record of FOC_STATE
        Updated.
    sense : record of DUTY_SENSE
        What the timer shows.
    seen : record of DUTY_SENSE
        Its angle and speed are written.

    Notes
    -----
    Where an edge is overdue the shaft is led on past its place from some speed on, as a lost edge is likelier there
    than a stop. Else the speed is no more than a sector over the time since the last edge, and the angle goes back to
    the middle of the sector, which is off by half a sector at most.
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
    begin = _FIRST_EDGE + _SECTOR * state.sector - state.place
    begin -= _TURN * floor(begin / _TURN + 0.5)
    inside = min(max(state.turned_on, begin), begin + _SECTOR)
    rate = state.rate
    was_led_on = state.led_on > 0.0
    state.led_on = abs(state.turned_on - inside)
    if state.led_on > 0.0:
        if state.led_on <= state.led_on_longest and abs(state.edge_rate) >= pairs * state.led_on_from:
            inside = state.turned_on
        else:
            state.is_overdue = 1 if was_led_on else 0
            # The longer no edge comes, the likelier the shaft has stopped somewhere in its sector.
            middle = begin + 0.5 * _SECTOR
            inside = middle + (inside - middle) * max(1.0 - 2.0 * state.led_on / _SECTOR, 0.0)
            state.led_on = 0.0
            most = pairs * greatest_speed(state)
            rate = min(max(rate, -most), most)
    if state.is_placed == 0:
        # Nothing shows yet where in its sector the shaft has started.
        inside = begin + 0.5 * _SECTOR
    seen.angle = (state.place + inside) / pairs
    seen.speed = rate / pairs
