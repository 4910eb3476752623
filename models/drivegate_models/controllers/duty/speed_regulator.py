"""Regulator of the speed: its requested torque, at a limited rate, and its anti-windup."""

from __future__ import annotations

from math import inf, sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import HALL_POSITION, SPEED_REFERENCE
from drivegate_models.controllers.duty.current_regulator import BANDWIDTH

LIMITED: Final = 0.999999
"""Share of the requested torque below which it counts as limited."""

# Bandwidth of the speed regulator relative to that of the currents, and its maximum for a light rotor. With a gain
# below the slope of the load's torque the integral is slow; the steepest load is a fan of this exponent at rated power.
_SPEED_SHARE = 0.02
_MOST_SPEED_SHARE = 0.1
_FAN_EXPONENT = 2.0
# Maximum bandwidth of a heavy rotor's regulator (rad/s): an encoder shows the mean speed of some milliseconds.
_MOST_SPEED_BANDWIDTH = 300.0
# Torque by which the regulator may answer the greatest error of the position sensor, over rated torque; and minimum
# rate of the filter of the seen speed relative to the bandwidth, which a rotor of 0.3 of the nominal inertia triples.
_SWING_TORQUE = 1.0
_LEAST_FILTER = 6.0
# Of a drive with Hall switches: their greatest error (rad electrical); the minimum rate of their filter, which is twice
# that of the observer of the shaft; and the swing over the greatest torque, whose limit would lower the mean speed.
HALL_ERROR: Final = 0.0437
_HALL_FILTER = 20.0
SWING_SHARE: Final = 0.5
_SPEED_INTEGRAL = 0.25
# Control periods in which a speed regulator may change its torque by the maximum torque.
_FULL_TORQUE_PERIODS = 80.0
# Torque requested for a speed error, over the greatest torque, from which the shaft is accelerating.
_ACCELERATING = 0.5


@inlined
def _speed_bandwidth(nameplate: Any, greatest: float) -> tuple[float, float]:
    """Return the bandwidth of the speed regulator, and the rate of the filter of its seen speed (rad/s).

    At a speed ``w`` an electrical error of amplitude ``e`` that comes ``n`` times a turn swings the seen speed by
    ``n w e / p``. A filter of rate ``f`` leaves less than ``f e / p`` of it at any ``w`` and ``n``. A regulator of
    bandwidth ``b`` answers that with less than ``b f J e / p`` of torque. This torque bounds the filter's rate, and the
    bandwidth where the filter would otherwise be too slow for the regulator. `greatest` is the maximum torque (N m).
    """
    slope = _FAN_EXPONENT * nameplate.rated_power / (nameplate.base_speed * nameplate.base_speed)
    current_bandwidth = BANDWIDTH / nameplate.control_period
    slowest = min(_SPEED_SHARE * current_bandwidth, _MOST_SPEED_BANDWIDTH)
    bandwidth = min(max(slope / nameplate.inertia, slowest), _MOST_SPEED_SHARE * current_bandwidth)
    if nameplate.position_error <= 0.0:
        return bandwidth, inf
    torque = _SWING_TORQUE * nameplate.rated_power / nameplate.base_speed
    both = torque * nameplate.pole_pairs / (nameplate.inertia * nameplate.position_error)
    bandwidth = min(bandwidth, sqrt(both / _LEAST_FILTER))
    if has_hall_switches(nameplate):
        left = min(torque, SWING_SHARE * greatest) / torque
        bandwidth = min(bandwidth, sqrt(left * both / _HALL_FILTER))
    return bandwidth, both / bandwidth


@inlined
def has_hall_switches(nameplate: Any) -> bool:
    """Return True if the stated error is that of Hall switches; that of another sensor is greater, and bounds more."""
    return bool(nameplate.position == HALL_POSITION and nameplate.position_error <= HALL_ERROR)


@inlined
def reset_speed_regulator(state: Any, nameplate: Any) -> tuple[float, float]:
    """Write the constants and reset everything else; the maximum torque must be set.

    Return the bandwidth of the regulator, and the rate of the filter of its seen speed (rad/s).
    """
    bandwidth, filter_rate = _speed_bandwidth(nameplate, state.greatest_torque)
    state.regulates_speed = 1 if nameplate.reference_kind == SPEED_REFERENCE else 0
    state.speed_gain = nameplate.inertia * bandwidth
    state.speed_integral_step = state.speed_gain * _SPEED_INTEGRAL * bandwidth * nameplate.control_period
    state.torque_step = state.greatest_torque / _FULL_TORQUE_PERIODS
    state.speed_integral = 0.0
    state.torque = 0.0
    return bandwidth, filter_rate


@inlined
def requested_torque(state: Any, reference: float, speed: float) -> float:
    """Return the torque requested by the reference (N m): the reference itself, or the speed regulator's output."""
    if state.regulates_speed == 0:
        return reference
    error = reference - speed
    state.speed_integral += state.speed_integral_step * error
    return float(state.speed_gain * error + state.speed_integral)


@inlined
def ramped(state: Any, requested: float) -> float:
    """Return the requested torque in this period (N m); that of a speed regulator changes at a limited rate."""
    if state.regulates_speed == 0:
        return requested
    within = min(max(requested, -state.greatest_torque), state.greatest_torque)
    state.torque = min(max(within, state.torque - state.torque_step), state.torque + state.torque_step)
    return float(state.torque)


@inlined
def unwind_speed(state: Any, reference: float, speed: float, requested: float, possible: float) -> None:
    """Anti-windup: stop the speed regulator's integral if the limits do not allow the requested torque.

    The limited rate alone only counts while the shaft accelerates. Otherwise a seen speed that swings within a turn
    would stop the integral in one half of each swing, and lower the mean speed.
    """
    error = reference - speed
    limited = state.torque
    if state.speed_gain * abs(error) > _ACCELERATING * state.greatest_torque:
        limited = requested
    if state.regulates_speed == 1 and abs(possible) < LIMITED * abs(limited) and requested * error > 0.0:
        state.speed_integral -= state.speed_integral_step * error
