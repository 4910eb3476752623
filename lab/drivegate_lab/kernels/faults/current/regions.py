"""Faults that occur only in a small region of speeds and loads."""

from __future__ import annotations

from typing import Any

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.units import RPM


@inlined
def cap_speed_reference(state: Any, fault: int) -> None:
    """Limit the speed reference in the controller's copy of the Sense, or its rate."""
    sense = state.sense
    if fault == faults.SPEED_CAPPED:
        sense.speed_reference = min(sense.speed_reference, state.size)
    elif fault == faults.BEYOND_RAMPED:
        if state.memory > state.extent and sense.speed_reference > state.extent:
            slowest, fastest = state.memory - state.size, state.memory + state.size
            sense.speed_reference = min(max(sense.speed_reference, slowest), fastest)
        state.memory = sense.speed_reference


@inlined
def alter_in_region(state: Any, fault: int, command: Any) -> None:
    """Change the command in a region of speeds and loads."""
    controller, sense = state.controller, state.sense
    if controller.advancing == 0:
        return
    rpm = sense.speed * RPM
    inside = state.first_rpm < rpm < state.last_rpm
    if fault == faults.CORNER_WITHOUT_LIMIT:
        light = controller.mode == HOLDING and sense.current_magnitude_sum < state.extent
        if light and inside:
            command.advance_angle = state.size
    elif fault == faults.WRONG_ROW:
        if inside:
            command.advance_angle = max(command.advance_angle, state.size)
    elif fault == faults.REFERENCE_FLOOR and rpm > state.first_rpm:
        command.current_reference = max(command.current_reference, state.size)
