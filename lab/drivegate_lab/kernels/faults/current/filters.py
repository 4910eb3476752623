"""Faults of filters, and of quantities that change from step to step."""

from __future__ import annotations

from typing import Any, Final

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_lab.kernels.faults.current.clocks import truncated
from drivegate_models.compilation.kernels import inlined

# Share of the input's change that the integer filter adopts in each step.
_TAKEN_OVER: Final = 1.0 / 16.0


@inlined
def low_pass(state: Any, value: float) -> float:
    """Return a value after the low-pass filter (same unit), which starts from its first input.

    `memory` is the filter's output; `latched` is 1 once it has started.
    """
    if state.latched == 0:
        state.latched = 1
        state.memory = value
    state.memory += state.size * (value - state.memory)
    filtered: float = state.memory
    return filtered


@inlined
def filter_sense(state: Any, fault: int) -> None:
    """Filter a signal in the controller's copy of the Sense."""
    sense = state.sense
    if fault == faults.SPEED_FILTERED:
        sense.speed = low_pass(state, sense.speed)
    elif fault == faults.SUM_FILTERED:
        sense.current_magnitude_sum = low_pass(state, sense.current_magnitude_sum)
    elif fault == faults.SPEED_FILTER_STICKS:
        if state.steps == 1:
            state.memory = sense.speed
        state.memory += truncated(sense.speed - state.memory, state.size) * _TAKEN_OVER
        sense.speed = state.memory


@inlined
def filter_command(state: Any, fault: int, command: Any) -> None:
    """Filter a part of the controller's command."""
    controller, sense = state.controller, state.sense
    if fault == faults.BASE_SPEED_FILTERED:
        filtered = low_pass(state, sense.speed)
        if sense.speed < controller.base_speed <= filtered:
            command.advance_angle = state.late_angle
        state.late_angle = command.advance_angle
    elif fault == faults.ESTIMATE_FILTERED:
        command.input_power = low_pass(state, command.input_power)
    elif fault == faults.SUPPLY_FILTERED:
        command.input_power = low_pass(state, sense.half_supply_voltage) * sense.current_magnitude_sum
    elif fault == faults.DIFFERENTIATED:
        if state.steps > 1:
            acceleration = (sense.speed - state.memory) / state.size
            damped = command.current_reference - state.extent * acceleration
            command.current_reference = min(max(damped, 0.0), controller.current_limit)
        state.memory = sense.speed
    elif fault == faults.SLEWED:
        last = state.late_reference
        slewed = min(max(command.current_reference, last - state.size), last + state.size)
        command.current_reference = min(max(slewed, 0.0), controller.current_limit)
        state.late_reference = command.current_reference
