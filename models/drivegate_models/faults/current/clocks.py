"""Faults of clocks, counters and whole numbers."""

from __future__ import annotations

from math import floor, trunc
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.protection import rearm
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.faults.current import state as faults

# Of the search at the pace of 1 (s).
_DECISION_PERIOD: Final = 0.1
_MILLISECONDS: Final = 1000.0


@inlined
def cut_off(value: float, step: float) -> float:
    """Return the whole steps in a value.

    Parameters
    ----------
    value, step : float
        In one unit.

    Returns
    -------
    float
        The multiple of the step next to the value toward zero.
    """
    return trunc(value / step) * step


@inlined
def wrapped(value: float, limit: float) -> float:
    """Return a value as a number with a sign holds it that overflows.

    Parameters
    ----------
    value, limit : float
        In one unit.

    Returns
    -------
    float
        From minus the limit up to the limit.
    """
    return (value + limit) % (2.0 * limit) - limit


@inlined
def alter_sense_by_rounding(state: Any, fault: int) -> None:
    """Change what the controller is shown by how it keeps numbers.

    Parameters
    ----------
    state : record of FAULTY_STATE
        Its copy of the Sense is changed.
    fault : int
        The fault.
    """
    sense = state.sense
    if fault == faults.SPEED_IN_STEPS:
        sense.speed = cut_off(sense.speed, state.size)
    elif fault == faults.ERROR_OVERFLOWS:
        sense.speed = sense.speed_reference - wrapped(sense.speed_reference - sense.speed, state.size)


@inlined
def alter_search_by_counters(state: Any, fault: int) -> None:
    """Change what the search remembers by how it counts, ahead of a step.

    Parameters
    ----------
    fault : int
        The fault.
    """
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
    """Change what regulator and search have come to by how they keep numbers, behind a step.

    Parameters
    ----------
    fault : int
        The fault.
    """
    controller, before = state.controller, state.before
    if fault == faults.INTEGRAL_IN_STEPS:
        controller.integral = before.integral + cut_off(controller.integral - before.integral, state.size)
    elif fault == faults.REARMS_COUNTED and before.mode == HOLDING and controller.mode != HOLDING:
        state.tally += 1


@inlined
def round_angle(state: Any, fault: int, command: Any) -> None:
    """Change the angle by how it, or what it follows from, is kept.

    Parameters
    ----------
    fault : int
        The fault.
    """
    if fault == faults.ANGLE_IN_STEPS:
        command.advance_angle = cut_off(command.advance_angle, state.size)
    elif fault == faults.REARMS_COUNTED and state.tally >= state.size and state.controller.advancing == 1:
        command.advance_angle = max(command.advance_angle - state.controller.offset, 0.0)


@inlined
def search_has_ended(state: Any, fault: int) -> bool:
    """Return whether the count of runs has brought the search to its end.

    Parameters
    ----------
    fault : int
        The fault.

    Returns
    -------
    bool
        False for other faults.
    """
    if fault != faults.RUNS_COUNTED:
        return False
    if state.steps == 1:
        state.tally += 1
    return bool(state.tally >= state.size)
