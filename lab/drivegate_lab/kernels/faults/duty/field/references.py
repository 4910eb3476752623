"""Faults of what a controller makes of its reference: falls at the voltage limit, stops, small and large ones."""

from __future__ import annotations

from typing import Any, Final

from drivegate_lab.kernels.faults.duty.field import state as faults
from drivegate_models.compilation.kernels import inlined

# Speed over base speed below which the shaft counts as stopped (1).
_STOPPED: Final = 0.02


@inlined
def alter_after_fall(state: Any, fault: int) -> None:
    """Keep a torque, or weakening, after a reference that could not be reached."""
    sense = state.sense
    is_beyond = abs(sense.speed) > state.base_speed and sense.reference * abs(sense.speed) > state.size
    if sense.reference <= 0.0:
        state.stage = 0
    elif is_beyond:
        state.stage = 1
        state.memory = sense.reference
    if state.stage == 1 and not is_beyond:
        if fault == faults.FALL_MISSED:
            sense.reference = state.memory
        else:
            state.direct_hidden = state.extent


@inlined
def alter_after_stop(state: Any, fault: int) -> None:
    """Keep weakening, or limit the torque, once the shaft has stopped from deep weakening."""
    speed = abs(state.sense.speed)
    if state.stage == 0 and speed > state.size:
        state.stage = 1
    elif state.stage == 1 and speed < _STOPPED * state.base_speed:
        state.stage = 2
    if state.stage < 2:
        return
    if fault == faults.TORQUE_CUT_AFTER_STOP:
        state.controller.greatest_torque = state.extent
    elif speed < state.base_speed:
        state.direct_hidden = state.extent


@inlined
def alter_size(state: Any, fault: int) -> None:
    """Drop small references, or limit how fast they change."""
    sense = state.sense
    if fault == faults.SMALL_DROPPED:
        if abs(sense.reference) < state.size:
            sense.reference = 0.0
    elif fault == faults.SMALL_BRAKING_DROPPED:
        if -state.size < sense.reference < 0.0:
            sense.reference = 0.0
    elif fault == faults.TORQUE_SLEWED:
        if state.steps == 1:
            state.memory = sense.reference
        change = sense.reference - state.memory
        state.memory += min(max(change, -state.size), state.size)
        sense.reference = state.memory


@inlined
def alter_regulator(state: Any, fault: int) -> None:
    """Change the integral of the speed regulator, or its torque, before a step."""
    sense, controller = state.sense, state.controller
    if fault == faults.INTEGRAL_CLEARED:
        if state.steps > 1 and sense.reference != state.reference_before:
            controller.speed_integral = 0.0
        state.reference_before = sense.reference
    elif fault == faults.LEAKS_AT_ZERO:
        if sense.reference == 0.0:
            controller.speed_integral *= 1.0 - state.size
    elif fault == faults.PARKS_AT_ZERO:
        if sense.reference != 0.0:
            state.count = 0
        elif abs(sense.speed) < _STOPPED * state.base_speed or state.count >= state.size:
            state.count += 1
        state.is_off = 1 if state.count >= state.size else 0


@inlined
def limit_torque(state: Any, fault: int) -> None:
    """Limit the torque that the speed regulator may request in the step to come."""
    controller = state.controller
    if state.steps == 1:
        state.memory = controller.greatest_torque
    drives = controller.torque * state.sense.speed > 0.0
    if (fault == faults.DRIVING_LIMITED) == drives:
        controller.greatest_torque = min(state.size, state.memory)
    else:
        controller.greatest_torque = state.memory


@inlined
def wind_up(state: Any, before: float) -> None:
    """Let the integral go on, from its value before the step, where a negative torque is cut off."""
    controller = state.controller
    if controller.torque <= 0.0:
        controller.torque = 0.0
        error = state.sense.reference - state.sense.speed
        controller.speed_integral = before + controller.speed_integral_step * error
