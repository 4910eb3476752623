"""The faulty controllers behind the native interface: a built-in step with one fault before or behind it.

The built-in controllers know nothing of it. Faults that are only other constants need nothing here.
"""

from __future__ import annotations

from functools import cache
from math import inf, isfinite, pi, radians
from typing import Any, Final

import numba
from numba import types
from numba.np.numpy_support import carray

from drivegate_models import faulty_state as faults
from drivegate_models.builtin_controllers import step_state
from drivegate_models.compilation import KEEPS_CACHE, unfused
from drivegate_models.contract import COMMAND, SENSE
from drivegate_models.faulty_state import FAULTY_STATE
from drivegate_models.native_memory import double_at
from drivegate_models.optimal_search import HOLDING, SEARCHING, SETTLING

_MIRROR: Final = 200.0
_WORD: Final = 65.536
_RIPPLE_STEPS: Final = 4

# Feasible edge at rated power and nominal R, L and EMF constant (rpm, degrees), and 1.5 degrees to spare.
_TABLE_RPM: Final = (550.0, 600.0, 700.0, 1000.0, 1150.0, 1200.0, 1350.0, 1500.0, 2000.0)
_TABLE_DEGREES: Final = (27.4, 28.6, 34.1, 34.7, 39.2, 41.6, 47.7, 53.4, 59.4)


@unfused
def sum_of_samples(sense: Any, phases: int, signed: bool) -> float:
    """Return the sum of the phase currents of this instant.

    Parameters
    ----------
    sense : record of SENSE
        What the sensors saw.
    phases : int
        Number of phases to add, from the first one.
    signed : bool
        Whether they are added with their signs.

    Returns
    -------
    float
        Sum (A).
    """
    total = 0.0
    for phase in range(phases):
        current = double_at(sense.phase_currents, phase)
        total += current if signed else abs(current)
    return total


@unfused
def alter_sense(fault: int, sense: Any) -> None:
    """Change what the controller is shown.

    Parameters
    ----------
    fault : int
        The fault.
    sense : record of SENSE
        The controller's own copy; changed.
    """
    if fault == faults.SUM_MIRRORED:
        sense.current_magnitude_sum = _MIRROR - sense.current_magnitude_sum
    elif fault == faults.SUM_WITHOUT_MAGNITUDES:
        sense.current_magnitude_sum = sum_of_samples(sense, sense.phase_count, True)
    elif fault == faults.SUM_WITHOUT_LAST_PHASE:
        sense.current_magnitude_sum = sum_of_samples(sense, sense.phase_count - 1, False)
    elif fault == faults.SUM_OVERFLOWS:
        wrapped = sense.current_magnitude_sum + 0.5 * _WORD
        sense.current_magnitude_sum = wrapped % _WORD - 0.5 * _WORD


@unfused
def alter_search_before(state: Any, fault: int) -> None:
    """Change what the search remembers, ahead of a step.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated.
    fault : int
        The fault.
    """
    controller = state.controller
    deciding = controller.count + 1 >= controller.decision_steps
    if fault == faults.STALE_POWER:
        if state.latched == 1:
            controller.old_power = state.memory
    elif fault == faults.SATURATION_IGNORED:
        controller.saturated = 0
        controller.saturated_run = 0
    elif fault == faults.NO_WALK_BACK:
        controller.moved = 0.0
        controller.saturated_run = 0
        controller.good_integral = inf
    elif fault == faults.NEVER_REARMS:
        if controller.mode == HOLDING:
            controller.quiet = 0
            controller.saturated_run = 0
            controller.good_integral = inf
    elif fault == faults.FALLING_LOAD_IGNORED and deciding and controller.mode == HOLDING:
        power = (controller.power_sum + state.sense.current_magnitude_sum) / (controller.count + 1)
        controller.held_power = min(controller.held_power, power)


@unfused
def alter_search_after(state: Any, fault: int) -> None:
    """Change what the search has come to, behind a step.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated.
    fault : int
        The fault.
    """
    controller, before, sense = state.controller, state.before, state.sense
    if fault == faults.NEVER_RESTS:
        if controller.mode == HOLDING:
            controller.mode = SEARCHING
            controller.step = controller.first_step
            controller.forbidden = -inf
    elif fault == faults.STALE_POWER:
        asked_anew = isfinite(before.speed_reference) and sense.speed_reference != before.speed_reference
        if asked_anew and before.mode == HOLDING:
            state.latched = 1
            state.memory = before.held_power
    elif fault == faults.NO_ANTI_WINDUP and controller.offset == before.offset:
        error = sense.speed_reference - sense.speed
        controller.integral = before.integral + controller.integral_step * error


@unfused
def angle_of_table(speed: float) -> float:
    """Return the advance angle of the table for the nominal drive.

    Parameters
    ----------
    speed : float
        Shaft speed (rad/s).

    Returns
    -------
    float
        Angle (rad electrical), interpolated; the last one beyond the table.
    """
    rpm = speed * 30.0 / pi
    last = len(_TABLE_RPM) - 1
    if rpm <= _TABLE_RPM[0]:
        return radians(_TABLE_DEGREES[0])
    for place in range(last):
        if rpm <= _TABLE_RPM[place + 1]:
            share = (rpm - _TABLE_RPM[place]) / (_TABLE_RPM[place + 1] - _TABLE_RPM[place])
            degrees = _TABLE_DEGREES[place] + share * (_TABLE_DEGREES[place + 1] - _TABLE_DEGREES[place])
            return radians(degrees)
    return radians(_TABLE_DEGREES[last])


@unfused
def alter_angle(state: Any, fault: int, angle: float) -> float:
    """Return the angle that is commanded instead of the controller's own.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated.
    fault : int
        The fault.
    angle : float
        The controller's angle (rad electrical).

    Returns
    -------
    float
        Angle (rad electrical).
    """
    controller, before, sense = state.controller, state.before, state.sense
    if fault == faults.ADVANCES_BELOW_BASE:
        return state.size if sense.speed < controller.base_speed else angle
    if fault == faults.BOOST_BEHIND_LIMITS:
        error = sense.speed_reference - sense.speed
        far = controller.advancing == 1 and abs(error) > controller.speed_tolerance
        return angle + state.size * error if far else angle
    if fault == faults.DRIFTS:
        drifted = state.memory + state.size * controller.control_period
        state.memory = drifted if controller.mode == HOLDING and controller.advancing == 1 else 0.0
        return min(angle + state.memory, 0.5 * pi)
    if fault == faults.ANGLE_CAPPED:
        return min(angle, state.size)
    if fault == faults.NOMINAL_TABLE:
        return angle_of_table(sense.speed) if controller.advancing == 1 else 0.0
    if fault == faults.TRUSTS_SUPPLY:
        moved = state.steps > 1 and sense.half_supply_voltage != state.memory
        state.memory = sense.half_supply_voltage
        return min(angle + state.size, 0.5 * pi) if moved and controller.advancing == 1 else angle
    if fault == faults.LATCHES_AT_STANDSTILL:
        if before.advancing == 1 and sense.speed <= 0.0:
            state.latched = 1
        return 0.0 if state.latched == 1 else angle
    return angle


@unfused
def alter_reference(state: Any, fault: int, reference: float) -> float:
    """Return the current reference that is commanded instead of the controller's own.

    Parameters
    ----------
    state : record of FAULTY_STATE
        The state.
    fault : int
        The fault.
    reference : float
        The controller's current reference (A).

    Returns
    -------
    float
        Current reference (A).
    """
    controller = state.controller
    if fault == faults.RIPPLING:
        upward = state.steps // _RIPPLE_STEPS % 2 == 0
        moved = reference + (state.size if upward else -state.size)
        return min(max(moved, 0.0), controller.current_limit)
    if fault == faults.REFERENCE_BELOW_ZERO and reference == 0.0:
        error = state.sense.speed_reference - state.sense.speed
        return min(controller.proportional * error + controller.integral, 0.0)
    return reference


@unfused
def alter_estimate(state: Any, fault: int, estimate: float) -> float:
    """Return the estimate of the input power that is given instead of the controller's own.

    Parameters
    ----------
    state : record of FAULTY_STATE
        The state.
    fault : int
        The fault.
    estimate : float
        The controller's estimate (W).

    Returns
    -------
    float
        Estimate (W).
    """
    sense = state.sense
    if fault == faults.SUM_MIRRORED:
        return sense.half_supply_voltage * (_MIRROR - sense.current_magnitude_sum)
    if fault == faults.ESTIMATE_SCALED:
        return state.size * estimate
    if fault == faults.ESTIMATE_AT_NOMINAL_SUPPLY:
        return state.controller.nominal_voltage * sense.current_magnitude_sum
    return estimate


@unfused
def compute_in_vain(state: Any) -> None:
    """Spend time, `size` divisions of it.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated, so that no compiler leaves the work out.
    """
    value = 1.0
    for _ in range(int(state.size)):
        value = 1.0 / (1.0 + value)
    state.memory = value


@unfused
def delay(state: Any, command: Any) -> None:
    """Exchange the command's reference and angle for those of the step before.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated.
    command : record of COMMAND
        Changed.
    """
    reference, angle = command.current_reference, command.advance_angle
    command.current_reference = state.late_reference
    command.advance_angle = state.late_angle
    state.late_reference = reference
    state.late_angle = angle


@unfused
def faulty_step_state(state: Any, sense: Any, command: Any) -> None:
    """Answer for one control period, with the fault that the state names.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated.
    sense : record of SENSE
        What the sensors saw; left as it is.
    command : record of COMMAND
        Receives the answer.
    """
    fault = state.fault
    state.steps += 1
    state.sense = sense
    alter_sense(fault, state.sense)
    alter_search_before(state, fault)
    state.before = state.controller
    step_state(state.controller, state.sense, command)
    alter_search_after(state, fault)
    command.current_reference = alter_reference(state, fault, command.current_reference)
    command.advance_angle = alter_angle(state, fault, command.advance_angle)
    command.input_power = alter_estimate(state, fault, command.input_power)
    if fault == faults.DELAYED:
        delay(state, command)
    if fault == faults.SLOW:
        compute_in_vain(state)


def _record_pointer(layout: Any) -> Any:
    pointer: Any = types.CPointer
    return pointer(numba.from_dtype(layout))


@cache
def faulty_step_function() -> Any:
    """Return the faulty controllers' `drivegate_step`, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a C function; keep the object.
    """
    signature = types.void(_record_pointer(FAULTY_STATE), _record_pointer(SENSE), _record_pointer(COMMAND))

    def drivegate_faulty_step(state: Any, sense: Any, command: Any) -> None:
        faulty_step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_faulty_step)
