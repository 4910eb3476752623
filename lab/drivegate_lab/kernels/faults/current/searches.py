"""Faults in the controller's Sense, and in the state of its search and its regulator."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any, Final

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.builtin import initial_angle
from drivegate_models.controllers.current.state import FOLLOWING, HOLDING, SEARCHING

# Range of a 16-bit number of milliamperes (A).
_WORD: Final = 65.536


@inlined
def sum_of_samples(sense: Any, phases: int, signed: bool) -> float:
    """Return the sum of the first `phases` phase currents at this instant (A), with signs if `signed`."""
    total = 0.0
    for phase in range(phases):
        current = double_at(sense.phase_currents, phase)
        total += current if signed else abs(current)
    return total


@inlined
def alter_sense(fault: int, size: float, sense: Any) -> None:
    """Change the controller's copy of the Sense; `size` is in the fault's unit."""
    if fault == faults.SUM_MIRRORED:
        sense.current_magnitude_sum = size - sense.current_magnitude_sum
    elif fault == faults.SUM_WITHOUT_MAGNITUDES:
        sense.current_magnitude_sum = sum_of_samples(sense, sense.phase_count, True)
    elif fault == faults.SUM_WITHOUT_LAST_PHASE:
        sense.current_magnitude_sum = sum_of_samples(sense, sense.phase_count - 1, False)
    elif fault == faults.SUM_OVERFLOWS:
        wrapped = sense.current_magnitude_sum + 0.5 * _WORD
        sense.current_magnitude_sum = wrapped % _WORD - 0.5 * _WORD


@inlined
def alter_sense_by_history(state: Any, fault: int) -> None:
    """Change the controller's copy of the Sense, depending on earlier steps or on one phase alone."""
    sense = state.sense
    if fault == faults.LOWEST_SUPPLY_KEPT:
        lowest = (
            sense.half_supply_voltage if state.steps == 1 else min(state.memory, sense.half_supply_voltage)
        )
        state.memory = lowest
        sense.half_supply_voltage = lowest
    elif fault == faults.ONE_PHASE_FOR_ALL:
        sense.current_magnitude_sum = sense.phase_count * abs(double_at(sense.phase_currents, 0))


@inlined
def mean_current_sum(state: Any) -> float:
    """Return the mean current sum of the present decision interval, including this step (A)."""
    controller = state.controller
    total = controller.power_sum + state.sense.current_magnitude_sum
    mean: float = total / (controller.count + 1)
    return mean


@inlined
def alter_search_before(state: Any, fault: int) -> None:
    """Change the state of the search, before a step."""
    controller = state.controller
    if fault == faults.STALE_POWER:
        if state.latched == 1:
            controller.old_power = state.memory
    elif fault == faults.SATURATION_IGNORED:
        controller.saturated = 0
        controller.saturated_run = 0
    elif fault == faults.NO_WALK_BACK:
        # The protections detect the search's own step by `moved`, and creeping by the integral of a good angle.
        controller.moved = 0.0
        controller.saturated_run = 0
        controller.good_integral = inf
    elif fault == faults.FALLING_LOAD_IGNORED:
        # Directly before the decision that would detect the fall; a rise is still detected.
        if controller.mode == HOLDING and controller.count + 1 >= controller.decision_steps:
            controller.held_power = min(controller.held_power, mean_current_sum(state))
            controller.rest_power = min(controller.rest_power, mean_current_sum(state))
    elif fault == faults.ANGLE_CAPPED:
        line = initial_angle(
            state.sense.speed, controller.base_speed, controller.angle_at_base, controller.angle_slope
        )
        controller.offset = min(controller.offset, state.size - line)
    elif fault == faults.LINE_IS_LIMIT:
        controller.offset = min(controller.offset, 0.0)


@inlined
def alter_search_after(state: Any, fault: int) -> None:
    """Change the state of search and regulator, after a step."""
    controller, before, sense = state.controller, state.before, state.sense
    if fault == faults.NEVER_RESTS:
        if controller.mode == HOLDING:
            controller.mode = SEARCHING
            controller.step = controller.first_step
            controller.forbidden = -inf
    elif fault == faults.STALE_POWER:
        is_new_reference = (
            isfinite(before.speed_reference) and sense.speed_reference != before.speed_reference
        )
        if is_new_reference and before.mode == HOLDING:
            state.latched = 1
            state.memory = before.held_power
    elif fault == faults.LEARNS:
        if not isfinite(before.speed_reference) and isfinite(controller.speed_reference):
            controller.offset = state.memory
        elif controller.mode == HOLDING or controller.mode == FOLLOWING:
            state.memory = controller.offset
    elif fault == faults.NO_ANTI_WINDUP and controller.offset == before.offset:
        error = sense.speed_reference - sense.speed
        controller.integral = before.integral + controller.integral_step * error
