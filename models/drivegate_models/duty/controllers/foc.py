"""Field-oriented control: speed, currents with decoupling, weakening, and duty ratios with a min-max zero sequence."""

from __future__ import annotations

from functools import cache
from math import nan, sqrt
from typing import Any, Final

import numba
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import LEG_PWM, SPEED_REFERENCE
from drivegate_models.duty.controllers.current_reference import (
    least_current_direct,
    most_torque_direct,
    torque_per_quadrature,
    with_torque,
    within_voltage,
)
from drivegate_models.duty.controllers.loss_model import least_loss_direct
from drivegate_models.duty.controllers.loss_search import LOOKING, SETTLING, forget_search, searched_offset
from drivegate_models.duty.controllers.state import FOC_STATE, MODELLED_LOSS, SEARCHED_LOSS, UNWEAKENED
from drivegate_models.machine.sine import cosine_sine

VOLTAGE_SHARE: Final = 0.98
"""Share of the undistorted voltage that references are made for; the rest is for the current regulators."""

# Bandwidths: of the currents over the sampling rate, which a delay of one and a half periods bears; of the speed over
# that one.
_CURRENT_BANDWIDTH = 0.2
_CURRENT_INTEGRAL = 0.1
_SPEED_SHARE = 0.02
_SPEED_INTEGRAL = 0.25
# Rate at which the voltage asks for further weakening, over that of the currents, and how far (of the current limit).
_WEAKENING_RATE = 0.02
_MOST_WEAKENING = 0.3
# Share of the wanted torque below which it counts as limited.
_GIVEN = 0.999999
_ROOT_THREE = sqrt(3.0)


@inlined
def reset_state(state: Any, nameplate: Any) -> None:
    """Write the constants of a controller and forget everything else.

    Parameters
    ----------
    state : record of FOC_STATE
        Overwritten, but for its aim.
    nameplate : record of DUTY_NAMEPLATE
        The drive's nominal data.
    """
    period = nameplate.control_period
    bandwidth = _CURRENT_BANDWIDTH / period
    speed_bandwidth = _SPEED_SHARE * bandwidth
    state.regulates_speed = 1 if nameplate.reference_kind == SPEED_REFERENCE else 0
    state.pole_pairs = nameplate.pole_pairs
    state.resistance = nameplate.resistance
    state.direct_inductance = nameplate.direct_inductance
    state.quadrature_inductance = nameplate.quadrature_inductance
    state.magnet_flux = nameplate.magnet_flux
    state.core_loss_conductance = nameplate.core_loss_conductance
    state.current_limit = nameplate.current_limit
    state.deepest = -min(nameplate.current_limit, nameplate.magnet_flux / nameplate.direct_inductance)
    most = most_torque_direct(state, state.current_limit)
    state.greatest_torque = torque_per_quadrature(state, most) * sqrt(
        state.current_limit * state.current_limit - most * most
    )
    state.lead = (nameplate.update_delay + 0.5) * period
    state.speed_gain = nameplate.inertia * speed_bandwidth
    state.speed_integral_step = state.speed_gain * _SPEED_INTEGRAL * speed_bandwidth * period
    state.direct_gain = bandwidth * nameplate.direct_inductance
    state.quadrature_gain = bandwidth * nameplate.quadrature_inductance
    rate = bandwidth * period
    state.direct_integral_step = rate * max(nameplate.resistance, _CURRENT_INTEGRAL * state.direct_gain)
    state.quadrature_integral_step = rate * max(
        nameplate.resistance, _CURRENT_INTEGRAL * state.quadrature_gain
    )
    # A volt too much at base speed is worth this current along the magnet's axis.
    per_volt = 1.0 / (nameplate.pole_pairs * nameplate.base_speed * nameplate.direct_inductance)
    state.weakening_step = _WEAKENING_RATE * rate * per_volt
    state.speed_integral = 0.0
    state.direct_integral = 0.0
    state.quadrature_integral = 0.0
    state.weakening = 0.0
    state.search_settling = int(SETTLING / period)
    state.search_looking = max(int(LOOKING / period), 1)
    forget_search(state, 0.0, 0.0)


@inlined
def _currents_for(
    state: Any, torque: float, electrical: float, voltage: float, power: float
) -> tuple[float, float]:
    """Return the currents for a torque, or for as much of it as the limits allow, by the controller's aim."""
    wanted = min(abs(torque), state.greatest_torque)
    direct = least_current_direct(state, wanted)
    if state.aim == MODELLED_LOSS:
        direct = least_loss_direct(state, wanted, electrical, direct)
    if state.aim != UNWEAKENED:
        direct, wanted = within_voltage(state, wanted, electrical, voltage, direct)
        direct += state.weakening
    if state.aim == SEARCHED_LOSS:
        direct += searched_offset(state, torque, electrical / state.pole_pairs, power)
    return with_torque(state, direct, wanted, torque < 0.0)


@inlined
def _wanted_torque(state: Any, reference: float, speed: float) -> float:
    """Return the torque that the reference asks for (N m)."""
    if state.regulates_speed == 0:
        return reference
    error = reference - speed
    state.speed_integral += state.speed_integral_step * error
    return float(state.speed_gain * error + state.speed_integral)


@inlined
def _unwind_speed(state: Any, reference: float, speed: float, wanted: float, given: float) -> None:
    """Let the speed regulator's integral stand where the limits give less torque than it wants."""
    error = reference - speed
    if state.regulates_speed == 1 and abs(given) < _GIVEN * abs(wanted) and wanted * error > 0.0:
        state.speed_integral -= state.speed_integral_step * error


@inlined
def _limited(along: float, across: float, limit: float) -> tuple[float, float]:
    """Return voltages within a limit, that along the magnet's axis first."""
    direct = min(max(along, -limit), limit)
    room = sqrt(max(limit * limit - direct * direct, 0.0))
    return direct, min(max(across, -room), room)


@inlined
def _write_ratios(command: Any, along: float, across: float, supply: float) -> None:
    """Write the duty ratios of a voltage in the frame that stands still, about the middle of the link."""
    first = along
    second = -0.5 * along + 0.5 * _ROOT_THREE * across
    third = -0.5 * along - 0.5 * _ROOT_THREE * across
    middle = 0.5 * (max(first, second, third) + min(first, second, third))
    command.first_duty = min(max(0.5 + (first - middle) / supply, 0.0), 1.0)
    command.second_duty = min(max(0.5 + (second - middle) / supply, 0.0), 1.0)
    command.third_duty = min(max(0.5 + (third - middle) / supply, 0.0), 1.0)
    command.first_leg = LEG_PWM
    command.second_leg = LEG_PWM
    command.third_leg = LEG_PWM


@inlined
def step_state(state: Any, sense: Any, command: Any) -> None:
    """Answer for one control period.

    Parameters
    ----------
    state : record of FOC_STATE
        Updated.
    sense : record of DUTY_SENSE
        What the sensors saw.
    command : record of DUTY_COMMAND
        Receives the answer.
    """
    currents = sense.phase_currents
    along = (2.0 * double_at(currents, 0) - double_at(currents, 1) - double_at(currents, 2)) / 3.0
    across = (double_at(currents, 1) - double_at(currents, 2)) / _ROOT_THREE
    angle = state.pole_pairs * sense.angle
    electrical = state.pole_pairs * sense.speed
    cosine, sine = cosine_sine(angle)
    direct = cosine * along + sine * across
    quadrature = cosine * across - sine * along

    limit = max(sense.supply_voltage, 0.0) / _ROOT_THREE
    wanted = _wanted_torque(state, sense.reference, sense.speed)
    direct_reference, quadrature_reference = _currents_for(
        state, wanted, electrical, VOLTAGE_SHARE * limit, sense.supply_voltage * sense.supply_current
    )
    given = torque_per_quadrature(state, direct_reference) * quadrature_reference
    _unwind_speed(state, sense.reference, sense.speed, wanted, given)

    direct_error = direct_reference - direct
    quadrature_error = quadrature_reference - quadrature
    opposed = electrical * (state.direct_inductance * direct + state.magnet_flux)
    direct_voltage = (
        state.direct_gain * direct_error
        + state.direct_integral
        - electrical * state.quadrature_inductance * quadrature
    )
    quadrature_voltage = state.quadrature_gain * quadrature_error + state.quadrature_integral + opposed
    direct_given, quadrature_given = _limited(direct_voltage, quadrature_voltage, limit)
    # What the limit has taken does not enter the integrals.
    state.direct_integral += state.direct_integral_step * (
        direct_error + (direct_given - direct_voltage) / state.direct_gain
    )
    state.quadrature_integral += state.quadrature_integral_step * (
        quadrature_error + (quadrature_given - quadrature_voltage) / state.quadrature_gain
    )
    used = sqrt(direct_voltage * direct_voltage + quadrature_voltage * quadrature_voltage)
    state.weakening += state.weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used)
    state.weakening = min(max(state.weakening, -_MOST_WEAKENING * state.current_limit), 0.0)

    cosine, sine = cosine_sine(angle + electrical * state.lead)
    _write_ratios(
        command,
        cosine * direct_given - sine * quadrature_given,
        sine * direct_given + cosine * quadrature_given,
        max(sense.supply_voltage, 1e-9),
    )
    command.next_period = 0.0
    command.torque = torque_per_quadrature(state, direct) * quadrature
    command.angle = sense.angle
    command.speed = sense.speed
    command.input_power = nan
    command.fault = 0


@cache
def step_function() -> Any:
    """Return the controller's step, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a C function; keep the object.
    """
    signature = step_signature(FOC_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)


@cache
def reset_function() -> Any:
    """Return the function that resets the controller, compiled.

    Returns
    -------
    Dispatcher
        Takes the state, shape (1,) of FOC_STATE, and the nameplate, shape (1,) of DUTY_NAMEPLATE.
    """

    def reset(state: Any, nameplate: Any) -> None:
        reset_state(state[0], nameplate[0])

    return numba.njit(cache=KEEPS_CACHE)(reset)
