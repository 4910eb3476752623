"""Field-oriented control without a position sensor.

While the legs are off, the terminals show a shaft that turns already. A shaft at rest is aligned by a current vector,
which then turns and takes the rotor along. From the least speed on, an observer of the stator flux provides the angle
and the speed that the regulators of `foc` need. A reversal passes standstill with the turning vector again.
"""

from __future__ import annotations

from functools import cache
from math import sqrt
from typing import Any, Final

import numba
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import LEG_LOW
from drivegate_models.controllers.duty import foc
from drivegate_models.controllers.duty.current_reference import torque_per_quadrature
from drivegate_models.controllers.duty.current_regulator import rotor_currents
from drivegate_models.controllers.duty.flux_observer import (
    acted_voltage,
    observe_rotor,
    place_rotor,
    reset_flux_observer,
)
from drivegate_models.controllers.duty.plausibility import hold_safe_state
from drivegate_models.controllers.duty.reference_voltage import reset_voltage_share
from drivegate_models.controllers.duty.sensorless_state import (
    ALIGNING,
    RAMPING,
    RUNNING,
    SENSORLESS_STATE,
    WATCHING,
)
from drivegate_models.controllers.duty.terminal_watch import (
    AT_REST,
    FOLLOWED,
    reset_watch,
    turn_off,
    watch_terminals,
)
from drivegate_models.controllers.duty.turning_field import (
    align,
    ease_current,
    follow_induced,
    learn_resistance,
    place_field,
    place_loaded_field,
    reset_field,
    rotor_of_field,
    turn_field,
)
from drivegate_models.machine.rotor_frame import from_phases

LOST_ROTOR: Final = 7
"""Fault code of a rotor that the observer has lost."""

# Speeds over the least one: of handover, of the return to the turning vector, and from which the rotor is lost.
# References below the last share stop the drive.
_HANDOVER: Final = 1.15
_RETURN: Final = 1.1
_STALLED: Final = 0.5
_STOPPED: Final = 0.5
# Least speed over base speed on a drive with a sensor, which states none.
_LEAST_SHARE: Final = 0.1
# Greatest difference between the observed and the given speed at handover (1), for how long (s), and how long it is
# waited for in periods of the swing and in seconds. Error of the flux (1) and time (s) of a rotor that is lost.
_AGREEMENT: Final = 0.1
_AGREED: Final = 0.02
_WAITED_PERIODS: Final = 6.0
_WAITED: Final = 0.15
_FLUX_ERROR: Final = 0.5
_LOST: Final = 0.02
# Time for which the vector holds a rotor whose reference is 0 (s), and least bandwidth of the speed regulator
# (rad/s): a load must not stop the shaft at the least speed.
_HELD: Final = 0.5
_SPEED_BANDWIDTH: Final = 80.0
# Share of an inductance that the nameplate's may be off by (1).
_OTHER_INDUCTANCE: Final = 0.2
# Share of the link voltage between lines from which legs that are off rectify.
_RECTIFIES: Final = 1.0


@inlined
def reset_state(state: Any, nameplate: Any) -> None:
    """Write the constants and reset everything else."""
    machine = state.machine
    foc.reset_state(machine, nameplate)
    faster = max(_SPEED_BANDWIDTH * nameplate.inertia / machine.speed_gain, 1.0)
    machine.speed_gain *= faster
    machine.speed_integral_step *= faster * faster
    state.fault = 0
    least = nameplate.least_speed if nameplate.least_speed > 0.0 else _LEAST_SHARE * nameplate.base_speed
    state.least_speed = nameplate.pole_pairs * least
    state.handover_speed = _HANDOVER * state.least_speed
    state.agreed_periods = int(_AGREED / nameplate.control_period) + 1
    state.lost_periods = int(_LOST / nameplate.control_period) + 1
    reset_flux_observer(state, nameplate)
    _slow_down(state, nameplate)
    reset_field(state, nameplate)
    state.sense_of_start = 1.0
    _enter(state, WATCHING)


@inlined
def _slow_down(state: Any, nameplate: Any) -> None:
    """Slow observer and speed regulator down until an inductance that is off cannot have both swing.

    A current that changes then turns the observed angle, and the regulator answers the speed that this seems to be.
    """
    machine, flux = state.machine, nameplate.magnet_flux
    current = machine.speed_gain / (nameplate.pole_pairs * torque_per_quadrature(machine, 0.0))
    turned = _OTHER_INDUCTANCE * nameplate.quadrature_inductance * current / flux
    slower = sqrt(min(1.0 / (turned * state.bandwidth), 1.0))
    state.bandwidth *= slower
    machine.speed_gain *= slower
    machine.speed_integral_step *= slower * slower


@inlined
def _enter(state: Any, mode: int) -> None:
    """Begin a mode."""
    state.mode = mode
    state.age = 0
    state.agreed = 0
    state.lost = 0
    reset_watch(state)


@inlined
def _wanted_sense(state: Any, sense: Any) -> float:
    """Return the sense of rotation that the reference asks for, 0 for none."""
    electrical = float(state.machine.pole_pairs * sense.reference)
    if abs(electrical) < _STOPPED * state.least_speed:
        return 0.0
    return 1.0 if electrical > 0.0 else -1.0


@inlined
def _watch(state: Any, sense: Any, command: Any, before: tuple[float, float]) -> None:
    """Watch the terminals with all legs off; drive a shaft that turns, or start one at rest."""
    machine = state.machine
    turn_off(state, command)
    seen = watch_terminals(state, before)
    if seen == FOLLOWED:
        run_observed(state, 0.0)
    wanted = _wanted_sense(state, sense)
    if seen == AT_REST and machine.regulates_speed == 1 and wanted != 0.0:
        state.sense_of_start = wanted
        place_field(state, 0.0, 0.0)
        _reset_integrals(state, 0.0, 0.0)
        _enter(state, ALIGNING)


@inlined
def _reset_integrals(state: Any, direct: float, quadrature: float) -> None:
    """Begin the current regulators with the voltages across the resistance of d and q currents (A)."""
    machine = state.machine
    machine.direct_integral = machine.resistance * direct
    machine.quadrature_integral = machine.resistance * quadrature


@inlined
def run_observed(state: Any, torque: float) -> None:
    """Begin field-oriented control from a torque (N m)."""
    machine = state.machine
    reset_voltage_share(machine)
    machine.speed_integral = torque
    machine.torque = torque
    _enter(state, RUNNING)


@inlined
def _observed_currents(state: Any, sense: Any) -> tuple[float, float]:
    """Return the d and q currents in the observed frame (A), and make that the frame of the machine's Sense."""
    machine = state.machine
    machine.seen = sense
    machine.seen.angle = state.angle / machine.pole_pairs
    machine.seen.speed = state.speed / machine.pole_pairs
    return rotor_currents(machine, machine.seen)


@inlined
def _ramp(state: Any, sense: Any, command: Any) -> None:
    """Turn the current vector up to the speed of handover; hand over once the observer agrees."""
    machine = state.machine
    wanted = _wanted_sense(state, sense)
    target = wanted * state.handover_speed
    turn_field(state, sense, command, target, state.current)
    if state.agreed == 0:
        place_rotor(state, rotor_of_field(state), state.field_speed, state.along_before, state.across_before)
    if state.field_speed != target:
        state.age = 0
        state.agreed = 0
        state.current = state.start_current
        return
    if wanted == 0.0:
        if state.age * machine.control_period > _HELD:
            _enter(state, WATCHING)
        return
    # The observer is left to itself where the current disturbs it least.
    eased = ease_current(state)
    if state.agreed == 0:
        state.agreed = 1 if eased else 0
    else:
        agrees = abs(state.speed - target) < _AGREEMENT * abs(target)
        agrees = agrees and abs(state.flux_error) < _FLUX_ERROR
        state.agreed = state.agreed + 1 if agrees else 0
    if state.agreed >= state.agreed_periods:
        direct, quadrature = _observed_currents(state, sense)
        _reset_integrals(state, direct, quadrature)
        run_observed(state, torque_per_quadrature(machine, direct) * quadrature)
        return
    waited = max(_WAITED_PERIODS * state.swing_period, _WAITED)
    if state.age * machine.control_period > waited:
        state.fault = LOST_ROTOR


@inlined
def _return_to_field(state: Any, direct: float, quadrature: float) -> None:
    """Take the rotor through standstill by the turning vector, which begins with the present torque and speed."""
    machine = state.machine
    torque = torque_per_quadrature(machine, direct) * quadrature
    place_loaded_field(state, state.angle, state.speed, torque)
    _reset_integrals(state, state.start_current, 0.0)
    _enter(state, RAMPING)


@inlined
def _drive(state: Any, sense: Any, command: Any) -> None:
    """Control by the observed angle and speed, or leave that below the least speed."""
    machine = state.machine
    direct, quadrature = _observed_currents(state, sense)
    forward = 1.0 if state.speed >= 0.0 else -1.0
    if machine.regulates_speed == 1:
        wanted = _wanted_sense(state, sense)
        least = state.least_speed / machine.pole_pairs
        if wanted == forward:
            machine.seen.reference = wanted * max(abs(sense.reference), least)
        else:
            machine.seen.reference = forward * least
            if abs(state.speed) < _RETURN * state.least_speed:
                _return_to_field(state, direct, quadrature)
    elif abs(state.speed) < _STALLED * state.least_speed:
        _enter(state, WATCHING)
    seen = machine.seen
    foc.regulate(machine, seen, command, seen.speed, direct, quadrature)
    command.angle = seen.angle
    command.speed = seen.speed
    stalls = abs(state.speed) < _STALLED * state.least_speed and state.mode == RUNNING
    is_lost = stalls or abs(state.flux_error) > _FLUX_ERROR
    state.lost = state.lost + 1 if is_lost else 0
    if state.lost >= state.lost_periods:
        state.fault = LOST_ROTOR


@inlined
def _hold_safe(state: Any, sense: Any, command: Any) -> None:
    """Command all legs off, or all low where the EMF between lines is above the link."""
    machine = state.machine
    machine.fault = state.fault
    hold_safe_state(machine, command)
    emf = sqrt(3.0) * abs(state.speed) * machine.magnet_flux
    if emf > _RECTIFIES * sense.supply_voltage:
        command.first_leg = LEG_LOW
        command.second_leg = LEG_LOW
        command.third_leg = LEG_LOW


@inlined
def step_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period."""
    if state.fault != 0:
        _hold_safe(state, sense, command)
        return
    currents = sense.phase_currents
    along, across = from_phases(double_at(currents, 0), double_at(currents, 1), double_at(currents, 2))
    before = state.along_terminal, state.across_terminal
    voltage = acted_voltage(state, sense)
    observe_rotor(state, along, across, voltage)
    follow_induced(state, along, across, voltage)
    state.along_before, state.across_before = along, across
    if state.mode == WATCHING:
        _watch(state, sense, command, before)
    elif state.mode == ALIGNING:
        if align(state, sense, command):
            learn_resistance(state)
            place_rotor(state, state.field, 0.0, along, across)
            _enter(state, RAMPING)
    elif state.mode == RAMPING:
        _ramp(state, sense, command)
    else:
        _drive(state, sense, command)
    state.age += 1
    if state.fault != 0:
        _hold_safe(state, sense, command)


@cache
def step_function() -> Any:
    """Return the controller's step, compiled; the caller must retain the object."""
    signature = step_signature(SENSORLESS_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)


@cache
def reset_function() -> Any:
    """Return the compiled function that resets the controller, with the arguments of `foc`'s."""

    def reset(state: Any, nameplate: Any) -> None:
        reset_state(state[0], nameplate[0])

    return numba.njit(cache=KEEPS_CACHE)(reset)
