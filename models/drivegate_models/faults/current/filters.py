"""Faults of filters, and of quantities that change from step to step."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.faults.current import state as faults
from drivegate_models.faults.current.clocks import cut_off

# Of what moves the filter of whole numbers, it takes over this.
_TAKEN_OVER: Final = 1.0 / 16.0


@inlined
def follow(state: Any, value: float) -> float:
    """Return a value after the low-pass filter, which starts from the first one that it sees.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Updated: `memory` is the filter's output, `latched` tells whether it has started.
    value : float
        The filter's input.

    Returns
    -------
    float
        Its output, in the same unit.
    """
    if state.latched == 0:
        state.latched = 1
        state.memory = value
    state.memory += state.size * (value - state.memory)
    followed: float = state.memory
    return followed


@inlined
def filter_sense(state: Any, fault: int) -> None:
    """Change what the controller is shown by a filter.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Its copy of the Sense is changed.
    fault : int
        The fault.
    """
    sense = state.sense
    if fault == faults.SPEED_FILTERED:
        sense.speed = follow(state, sense.speed)
    elif fault == faults.SUM_FILTERED:
        sense.current_magnitude_sum = follow(state, sense.current_magnitude_sum)
    elif fault == faults.SPEED_FILTER_STICKS:
        if state.steps == 1:
            state.memory = sense.speed
        state.memory += cut_off(sense.speed - state.memory, state.size) * _TAKEN_OVER
        sense.speed = state.memory


@inlined
def filter_command(state: Any, fault: int, command: Any) -> None:
    """Change what the controller answers by a filter.

    Parameters
    ----------
    fault : int
        The fault.
    """
    controller, sense = state.controller, state.sense
    if fault == faults.BASE_SPEED_FILTERED:
        filtered = follow(state, sense.speed)
        if sense.speed < controller.base_speed <= filtered:
            command.advance_angle = state.late_angle
        state.late_angle = command.advance_angle
    elif fault == faults.ESTIMATE_FILTERED:
        command.input_power = follow(state, command.input_power)
    elif fault == faults.SUPPLY_FILTERED:
        command.input_power = follow(state, sense.half_supply_voltage) * sense.current_magnitude_sum
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
