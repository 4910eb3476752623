"""Control of speed or torque with an observer of shaft and load.

The speed regulator has no integral: the observed load is added to its output. After Han, "From PID to active
disturbance rejection control", IEEE Transactions on Industrial Electronics 56(3), 2009. It shares the choice of
currents and of their voltage, the prediction of the flux and the Hall observer with the other controllers, but neither
their speed regulator nor their plausibility checks.
"""

from __future__ import annotations

from functools import cache
from math import inf, nan, pi, sqrt
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import SPEED_REFERENCE
from drivegate_models.controllers.duty.current_reference import (
    currents_for_torque,
    greatest_torque,
    least_current_direct,
    limited_by_voltage,
    torque_per_quadrature,
)
from drivegate_models.controllers.duty.current_regulator import (
    reset_regulator,
    rotor_currents,
    voltage_limit,
)
from drivegate_models.controllers.duty.derating import derate, reset_derating
from drivegate_models.controllers.duty.flux_prediction import regulate_flux, reset_prediction
from drivegate_models.controllers.duty.hall_observer import greatest_speed, reset_observer
from drivegate_models.controllers.duty.link_limits import limited_by_link, reset_link_limits
from drivegate_models.controllers.duty.plausibility import hold_safe_state
from drivegate_models.controllers.duty.position import locate_shaft, reset_position
from drivegate_models.controllers.duty.reference_voltage import (
    reset_voltage_share,
    share_voltage,
    with_reserve,
)
from drivegate_models.controllers.duty.residuals import detect_failure, reset_detector, watch_currents
from drivegate_models.controllers.duty.speed_regulator import SWING_SHARE, has_hall_switches
from drivegate_models.controllers.duty.state import FOC_STATE
from drivegate_models.machine.cycle import within_half_turn

LOAD_OBSERVER_STATE: Final = np.dtype(
    [
        # Machine data, modulation, flux prediction and Hall observer, as of the other controllers.
        ("machine", FOC_STATE),
        # Rate of the speed error (1/s), and corrections of the observer by the angle's error: of angle (1), speed
        # (1/s) and load (N m/rad).
        ("speed_rate", np.float64),
        ("angle_share", np.float64),
        ("rate_gain", np.float64),
        ("load_gain", np.float64),
        # Maximum change of the requested torque in a control period (N m).
        ("torque_step", np.float64),
        # Observed shaft: 1 once it has been seen, angle (rad), speed (rad/s), and load (N m).
        ("is_seen", np.int64),
        ("angle", np.float64),
        ("speed", np.float64),
        ("load", np.float64),
        # Requested torque (N m).
        ("torque", np.float64),
        # Failure detector: constants, code of the first fault, and counts of control periods; currents of the step
        # before (A, stationary frame, NaN at first), mean speed (rad/s, NaN at first), and means of the unexplained
        # voltage and of that which changes the currents (V); reference currents (A), mean error of the flux (V s,
        # infinite at first), and 1 while that error shrinks; angle of the step before (rad), what it turned until then
        # (NaN at first), what it is off its speed (rad electrical), and off the observed shaft (rad).
        ("base_speed", np.float64),
        ("stalling", np.float64),
        ("still_longest", np.int64),
        ("hall_still_longest", np.int64),
        ("fault", np.int64),
        ("sum_count", np.int64),
        ("still_count", np.int64),
        ("hall_before", np.int64),
        ("voltage_count", np.int64),
        ("off_count", np.int64),
        ("along_before", np.float64),
        ("across_before", np.float64),
        ("mean_speed", np.float64),
        ("direct_unexplained", np.float64),
        ("quadrature_unexplained", np.float64),
        ("direct_changing", np.float64),
        ("quadrature_changing", np.float64),
        ("missing", np.int64, (3,)),
        ("direct_aim", np.float64),
        ("quadrature_aim", np.float64),
        ("mean_error", np.float64),
        ("shrinks", np.int64),
        ("angle_before", np.float64),
        ("turned", np.float64),
        ("behind", np.float64),
        ("angle_missed", np.float64),
        # Angle of the step before (rad, NaN at first), what the shaft turned between its last two angles (rad), and
        # control periods without another one.
        ("voltage_angle", np.float64),
        ("edge_turn", np.float64),
        ("silent_count", np.int64),
    ],
    align=True,
)
"""State of the controller, in SI units; angle, speed and torques are the shaft's."""

# Rate of the speed error relative to the sampling rate; with an observer five times as fast, the shaft settles at
# 0.3 to 10 times the nominal inertia. It is faster where the torque of a fan rises steeply.
_SPEED_RATE: Final = 0.004
_MOST_SPEED_RATE: Final = 0.02
_FAN_EXPONENT: Final = 2.0
_OBSERVER: Final = 5.0
# Greatest torque by which regulator and observed load may answer an error of the position sensor, over rated torque and
# by the rate's square: both together answer it, at its worst frequency, by 15.5 J e / p at most.
_SWING_TORQUE: Final = 2.0
_ANSWERED: Final = 15.5
# The rate of the observer between Hall edges over that of the other one.
_HALL_OBSERVER: Final = 2.0
# Control periods in which the torque may change by the maximum torque, and the greatest observed load over it.
_FULL_TORQUE_PERIODS: Final = 40.0
_MOST_LOAD: Final = 4.0
_TURN: Final = 2.0 * pi


@inlined
def reset_state(state: Any, nameplate: Any) -> None:
    """Write the constants and reset everything else."""
    machine, period = state.machine, nameplate.control_period
    machine.control_period = period
    reset_regulator(machine, nameplate)
    reset_link_limits(machine, nameplate)
    reset_prediction(machine)
    machine.regulates_speed = 1 if nameplate.reference_kind == SPEED_REFERENCE else 0
    machine.core_loss_conductance = nameplate.core_loss_conductance
    machine.deepest = -nameplate.current_limit
    machine.added_flux = 0.0
    machine.greatest_torque = greatest_torque(machine)
    reset_derating(machine, nameplate)
    reset_voltage_share(machine)
    slope = _FAN_EXPONENT * nameplate.rated_power / (nameplate.base_speed * nameplate.base_speed)
    rate = min(max(slope / nameplate.inertia, _SPEED_RATE / period), _MOST_SPEED_RATE / period)
    if nameplate.position_error > 0.0:
        torque = _SWING_TORQUE * nameplate.rated_power / nameplate.base_speed
        answered = _ANSWERED * nameplate.inertia * nameplate.position_error / nameplate.pole_pairs
        if has_hall_switches(nameplate):
            torque = min(torque, SWING_SHARE * machine.greatest_torque)
            answered *= _HALL_OBSERVER
        rate = min(rate, sqrt(torque / answered))
    state.speed_rate = rate
    # All three poles of the observer are at 1 - share.
    share = 1.0 - 1.0 / (1.0 + _OBSERVER * rate * period)
    state.angle_share = 3.0 * share
    state.rate_gain = 3.0 * share * share / period
    state.load_gain = nameplate.inertia * share * share * share / (period * period)
    state.torque_step = machine.greatest_torque / _FULL_TORQUE_PERIODS
    state.is_seen = 0
    state.angle = 0.0
    state.speed = 0.0
    state.load = 0.0
    state.torque = 0.0
    reset_position(machine, nameplate, inf)
    reset_observer(machine, rate, nameplate.inertia)
    reset_detector(state, nameplate)


@inlined
def _expect_edge(state: Any, reference: float) -> None:
    """Attribute to the load that no Hall edge has come in the time that a sector takes at the reference (rad/s).

    Only edges correct the observed load, and a shaft that it stops has none: after a reversal, a load that opposes the
    rotation acts the other way.
    """
    machine = state.machine
    most = greatest_speed(machine)
    missing = reference - min(max(reference, -most), most)
    rate = machine.pole_pairs * state.speed_rate * state.speed_rate * machine.control_period
    greatest = machine.pole_pairs * machine.full_torque / machine.inertia
    machine.slowing = min(max(machine.slowing + rate * missing, -greatest), greatest)


@inlined
def _observe(state: Any, sense: Any) -> None:
    """Follow the shaft by the torque of the currents, and correct angle, speed and load by the measured angle."""
    machine = state.machine
    period = machine.control_period
    if sense.hall >= 0:
        if machine.regulates_speed == 1:
            _expect_edge(state, sense.reference)
        state.angle, state.speed = sense.angle, sense.speed
        state.load = machine.slowing * machine.inertia / machine.pole_pairs
        return
    if state.is_seen == 0:
        state.is_seen = 1
        state.angle, state.speed = sense.angle, sense.speed
        return
    gained = period * (machine.seen_torque - state.load) / machine.inertia
    state.angle += period * (state.speed + 0.5 * gained)
    state.speed += gained
    missed = within_half_turn(sense.angle - state.angle)
    state.angle_missed = missed
    state.angle += state.angle_share * missed
    state.speed += state.rate_gain * missed
    state.load -= state.load_gain * missed
    state.angle -= _TURN if state.angle > _TURN else 0.0
    state.angle += _TURN if state.angle < 0.0 else 0.0
    most = _MOST_LOAD * machine.full_torque
    state.load = min(max(state.load, -most), most)


@inlined
def _requested_torque(state: Any, reference: float) -> float:
    """Return the torque requested by the reference (N m): the reference itself, or the speed regulator's output."""
    machine = state.machine
    if machine.regulates_speed == 0:
        return reference
    torque = machine.inertia * state.speed_rate * (reference - state.speed) + state.load
    torque = min(max(torque, -machine.greatest_torque), machine.greatest_torque)
    state.torque = min(max(torque, state.torque - state.torque_step), state.torque + state.torque_step)
    return float(state.torque)


@inlined
def _currents_for(state: Any, torque: float, electrical: float, voltage: float) -> tuple[float, float]:
    """Return the d-axis and q-axis currents (A) for a torque (N m), or for as much of it as the limits allow."""
    machine = state.machine
    requested = min(abs(torque), machine.greatest_torque)
    voltage, resistance = with_reserve(machine, torque, requested, electrical, voltage)
    direct = least_current_direct(machine, requested)
    direct, requested = limited_by_voltage(machine, requested, electrical, voltage, resistance, direct)
    return currents_for_torque(machine, direct, requested, torque < 0.0)


@inlined
def step_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period."""
    machine = state.machine
    sense = locate_shaft(machine, sense)
    _observe(state, sense)
    direct, quadrature = rotor_currents(machine, sense)
    command.angle = sense.angle
    command.speed = sense.speed
    if detect_failure(state, sense, direct, quadrature):
        hold_safe_state(state, command)
        return
    derate(machine, sense, direct, quadrature)
    limit = voltage_limit(machine, sense)
    electrical = machine.pole_pairs * sense.speed
    direct_reference, quadrature_reference = _currents_for(
        state, _requested_torque(state, sense.reference), electrical, machine.voltage_share * limit
    )
    direct_reference, quadrature_reference = limited_by_link(
        machine, electrical, sense.supply_voltage, direct_reference, quadrature_reference
    )
    watch_currents(state, limit, direct, quadrature, direct_reference, quadrature_reference)
    used = regulate_flux(machine, sense, command, direct, quadrature, direct_reference, quadrature_reference)
    share_voltage(machine, used / max(limit, 1e-9))
    command.torque = torque_per_quadrature(machine, direct) * quadrature
    machine.seen_torque = command.torque
    machine.quadrature_before = machine.quadrature_seen
    machine.direct_seen, machine.quadrature_seen = direct, quadrature
    command.input_power = nan


@cache
def step_function() -> Any:
    """Return the controller's step, compiled; the caller must retain the object."""
    signature = step_signature(LOAD_OBSERVER_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)


@cache
def reset_function() -> Any:
    """Return the compiled function that resets the controller, with the arguments of `foc`'s."""

    def reset(state: Any, nameplate: Any) -> None:
        reset_state(state[0], nameplate[0])

    return numba.njit(cache=KEEPS_CACHE)(reset)
