"""Faults of clocks, counters and integer arithmetic."""

from __future__ import annotations

from math import floor, trunc
from typing import Any, Final

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.modes import rearm
from drivegate_models.controllers.current.state import HOLDING

# Decision period of the search on the drive tuned on (s).
_DECISION_PERIOD: Final = 0.1
_MILLISECONDS: Final = 1000.0


@inlined
def truncated(value: float, step: float) -> float:
    """Truncate a value toward zero to whole steps (same unit)."""
    return trunc(value / step) * step


@inlined
def wrapped(value: float, limit: float) -> float:
    """Return a value as a signed integer that overflows at `limit` (same unit)."""
    return (value + limit) % (2.0 * limit) - limit


@inlined
def alter_sense_by_rounding(state: Any, fault: int) -> None:
    """Change the controller's copy of the Sense by its number format."""
    sense = state.sense
    if fault == faults.SPEED_IN_STEPS:
        sense.speed = truncated(sense.speed, state.size)
    elif fault == faults.ERROR_OVERFLOWS:
        sense.speed = sense.speed_reference - wrapped(sense.speed_reference - sense.speed, state.size)


@inlined
def alter_search_by_counters(state: Any, fault: int) -> None:
    """Change the state of the search by its counters, before a step."""
    controller = state.controller
    if fault == faults.STEPS_OVERFLOW:
        if state.steps % int(state.size) == 0:
            rearm(controller)
    elif fault == faults.MILLISECONDS_OVERFLOW:
        turns = floor(state.sense.time * _MILLISECONDS / state.size)
        if state.steps > 1 and turns != state.memory:
            rearm(controller)
        state.memory = turns
    elif fault == faults.ALWAYS_DUE:
        if state.sense.time >= state.size:
            controller.decision_steps = 1
    elif fault == faults.CATCHES_UP:
        if state.steps == 1:
            state.tally = controller.decision_steps
        pace = controller.paced_period / controller.control_period
        due = floor(state.sense.time * pace / _DECISION_PERIOD)
        controller.decision_steps = 1 if state.memory < due else state.tally
        if controller.count + 1 >= controller.decision_steps and controller.advancing == 1:
            state.memory += 1.0
    elif fault == faults.POWER_SUM_OVERFLOWS:
        controller.power_sum = controller.power_sum % state.size
    elif fault == faults.COUNT_OVERFLOWS:
        controller.count = controller.count % int(state.size)


@inlined
def alter_search_by_rounding(state: Any, fault: int) -> None:
    """Change the state of regulator and search by their number format, after a step."""
    controller, before = state.controller, state.before
    if fault == faults.INTEGRAL_IN_STEPS:
        controller.integral = before.integral + truncated(controller.integral - before.integral, state.size)
    elif fault == faults.REARMS_COUNTED and before.mode == HOLDING and controller.mode != HOLDING:
        state.tally += 1


@inlined
def round_angle(state: Any, fault: int, command: Any) -> None:
    """Change the angle by its number format, or by a count of restarts."""
    if fault == faults.ANGLE_IN_STEPS:
        command.advance_angle = truncated(command.advance_angle, state.size)
    elif fault == faults.REARMS_COUNTED and state.tally >= state.size and state.controller.advancing == 1:
        command.advance_angle = max(command.advance_angle - state.controller.offset, 0.0)


@inlined
def search_has_ended(state: Any, fault: int) -> bool:
    """Return True if the count of runs has ended the search."""
    if fault != faults.RUNS_COUNTED:
        return False
    if state.steps == 1:
        state.tally += 1
    return bool(state.tally >= state.size)
