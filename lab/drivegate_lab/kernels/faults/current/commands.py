"""Faults in the controller's commands."""

from __future__ import annotations

from math import pi, radians
from typing import Any, Final

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_lab.kernels.faults.current.state import TABLE_ROWS
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.units import RPM

_RIPPLE_STEPS: Final = 4


@inlined
def angle_of_table(state: Any, speed: float) -> float:
    """Return the nominal drive's advance angle at a shaft speed (rad/s), from its table (rad electrical).

    It is interpolated, and constant beyond the ends of the table.
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
    """Change the advance angle, depending on the present Sense."""
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
def undo_search(state: Any, command: Any) -> None:
    """Undo the effect of the search in this step; the regulator continues."""
    integral, advancing = state.controller.integral, state.controller.advancing
    if advancing == 1:
        held = command.advance_angle + state.before.offset - state.controller.offset
        command.advance_angle = min(max(held, 0.0), 0.5 * pi)
    state.controller = state.before
    state.controller.integral = integral
    state.controller.advancing = advancing


@inlined
def alter_angle_by_history(state: Any, fault: int, command: Any) -> None:
    """Change the advance angle, depending on earlier steps."""
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
            undo_search(state, command)
    elif fault == faults.LATCHES_AT_STANDSTILL:
        if state.before.advancing == 1 and sense.speed <= 0.0:
            state.latched = 1
        if state.latched == 1:
            command.advance_angle = 0.0


@inlined
def alter_reference(state: Any, fault: int, command: Any) -> None:
    """Change the commanded current reference."""
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
    """Change the estimate of the input power."""
    sense = state.sense
    if fault == faults.SUM_MIRRORED:
        # Only the search uses the mirrored sum; the estimate uses the true one.
        command.input_power = sense.half_supply_voltage * (state.size - sense.current_magnitude_sum)
    elif fault == faults.ESTIMATE_SCALED:
        command.input_power *= state.size
    elif fault == faults.ESTIMATE_AT_NOMINAL_SUPPLY:
        command.input_power = state.controller.nominal_voltage * sense.current_magnitude_sum
    elif fault in (faults.SUM_FILTERED, faults.ONE_PHASE_FOR_ALL):
        command.input_power = sense.half_supply_voltage * state.true_sum


@inlined
def waste_time(state: Any) -> None:
    """Waste the time of `size` divisions; the result is stored so that no compiler removes them."""
    value = 1.0
    for _ in range(int(state.size)):
        value = 1.0 / (1.0 + value)
    state.memory = value


@inlined
def delay_command(state: Any, command: Any) -> None:
    """Replace the command's reference and angle by those of the preceding step."""
    reference, angle = command.current_reference, command.advance_angle
    command.current_reference = state.late_reference
    command.advance_angle = state.late_angle
    state.late_reference = reference
    state.late_angle = angle
