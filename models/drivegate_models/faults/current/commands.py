"""Faults of what a controller answers."""

from __future__ import annotations

from math import pi, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.faults.current import state as faults
from drivegate_models.faults.current.state import TABLE_ROWS
from drivegate_models.units import RPM

_RIPPLE_STEPS: Final = 4


@inlined
def angle_of_table(state: Any, speed: float) -> float:
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
    rpm = speed * RPM
    last = TABLE_ROWS - 1
    if rpm <= state.table_rpm[0]:
        return radians(state.table_degrees[0])
    for place in range(last):
        if rpm <= state.table_rpm[place + 1]:
            part = (rpm - state.table_rpm[place]) / (state.table_rpm[place + 1] - state.table_rpm[place])
            degrees = state.table_degrees[place] + part * (
                state.table_degrees[place + 1] - state.table_degrees[place]
            )
            return radians(degrees)
    return radians(state.table_degrees[last])


@inlined
def alter_angle(state: Any, fault: int, command: Any) -> None:
    """Change the advance angle by what the controller sees in this step.

    Parameters
    ----------
    fault : int
        The fault.
    """
    controller, sense = state.controller, state.sense
    advancing = controller.advancing == 1
    if fault == faults.ADVANCES_BELOW_BASE:
        if sense.speed < controller.base_speed:
            command.advance_angle = state.size
    elif fault == faults.BOOST_BEHIND_LIMITS:
        error = sense.speed_reference - sense.speed
        if advancing and abs(error) > controller.speed_tolerance:
            command.advance_angle += state.size * error
    elif fault == faults.ANGLE_CAPPED:
        command.advance_angle = min(command.advance_angle, state.size)
    elif fault == faults.NOMINAL_TABLE:
        command.advance_angle = angle_of_table(state, sense.speed) if advancing else 0.0
    elif fault == faults.UNLIMITED_LINE and advancing:
        above_base = sense.speed - controller.base_speed
        line = controller.angle_at_base + controller.angle_slope * above_base
        command.advance_angle = line + controller.offset
    elif fault == faults.BLIND_SPOT and advancing:
        rpm = sense.speed * RPM
        if state.first_rpm < rpm < state.last_rpm:
            command.advance_angle -= controller.offset


@inlined
def hold_search(state: Any, command: Any) -> None:
    """Undo whatever the search has done in this step; the regulator goes on."""
    integral, advancing = state.controller.integral, state.controller.advancing
    if advancing == 1:
        held = command.advance_angle + state.before.offset - state.controller.offset
        command.advance_angle = min(max(held, 0.0), 0.5 * pi)
    state.controller = state.before
    state.controller.integral = integral
    state.controller.advancing = advancing


@inlined
def alter_angle_by_history(state: Any, fault: int, command: Any) -> None:
    """Change the advance angle by what the fault remembers of earlier steps.

    Parameters
    ----------
    fault : int
        The fault.
    """
    controller, sense = state.controller, state.sense
    advancing = controller.advancing == 1
    if fault == faults.DRIFTS:
        drifted = state.memory + state.size * controller.control_period
        state.memory = drifted if advancing and controller.mode == HOLDING else 0.0
        command.advance_angle = min(command.advance_angle + state.memory, 0.5 * pi)
    elif fault == faults.TRUSTS_SUPPLY:
        if advancing and state.steps > 1 and sense.half_supply_voltage != state.memory:
            command.advance_angle = min(command.advance_angle + state.size, 0.5 * pi)
        state.memory = sense.half_supply_voltage
    elif fault == faults.NEVER_REARMS:
        if state.before.mode == HOLDING and sense.speed_reference == state.before.speed_reference:
            hold_search(state, command)
    elif fault == faults.LATCHES_AT_STANDSTILL:
        if state.before.advancing == 1 and sense.speed <= 0.0:
            state.latched = 1
        if state.latched == 1:
            command.advance_angle = 0.0


@inlined
def alter_reference(state: Any, fault: int, command: Any) -> None:
    """Change the current reference that the controller commands.

    Parameters
    ----------
    fault : int
        The fault.
    """
    controller = state.controller
    if fault == faults.RIPPLING:
        upward = state.steps // _RIPPLE_STEPS % 2 == 0
        moved = command.current_reference + (state.size if upward else -state.size)
        command.current_reference = min(max(moved, 0.0), controller.current_limit)
    elif fault == faults.REFERENCE_BELOW_ZERO and command.current_reference == 0.0:
        error = state.sense.speed_reference - state.sense.speed
        command.current_reference = min(controller.proportional * error + controller.integral, 0.0)


@inlined
def alter_estimate(state: Any, fault: int, command: Any) -> None:
    """Change the controller's estimate of its input power.

    Parameters
    ----------
    fault : int
        The fault.
    """
    sense = state.sense
    if fault == faults.SUM_MIRRORED:
        # The search alone is deceived.
        command.input_power = sense.half_supply_voltage * (state.size - sense.current_magnitude_sum)
    elif fault == faults.ESTIMATE_SCALED:
        command.input_power *= state.size
    elif fault == faults.ESTIMATE_AT_NOMINAL_SUPPLY:
        command.input_power = state.controller.nominal_voltage * sense.current_magnitude_sum
    elif fault in (faults.SUM_FILTERED, faults.ONE_PHASE_FOR_ALL):
        command.input_power = sense.half_supply_voltage * state.true_sum


@inlined
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


@inlined
def delay(state: Any, command: Any) -> None:
    """Exchange the command's reference and angle for those of the step before."""
    reference, angle = command.current_reference, command.advance_angle
    command.current_reference = state.late_reference
    command.advance_angle = state.late_angle
    state.late_reference = reference
    state.late_angle = angle
