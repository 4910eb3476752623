"""Faults of field-oriented control without a position sensor: what is wrong before and after each of its steps."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.controllers.duty.flux_observer import SPEED_GAIN
from drivegate_models.controllers.duty.foc_sensorless import step_state
from drivegate_models.controllers.duty.sensorless_state import (
    ALIGNING,
    RAMPING,
    SENSORLESS_STATE,
    WATCHING,
)

NEWER_VOLTAGE: Final = 1
"""The observer takes the voltage of the answer after the one that acted."""
ANGLE_NEGATED: Final = 2
"""The reported angle has the wrong sign."""
UNSIGNED_GAIN: Final = 3
"""The observer's gain grows with the signed speed in place of its magnitude."""
STANDSTILL_PRESUMED: Final = 4
"""A shaft that turns is started as one at rest."""
FIELD_FOR_EVER: Final = 5
"""The turning vector goes on whether the rotor follows or not."""
LOSS_UNTOLD: Final = 6
"""A rotor that is lost is not told."""
ELECTRICAL_ANGLE: Final = 7
"""The reported angle is the electrical one."""
STARTS_FORWARD: Final = 8
"""Every start turns forward."""
TURNS_FORWARD: Final = 9
"""Every shaft that turns is taken for turning forward."""
LATE_ANGLE: Final = 10
"""The reported angle is that of the preceding control period."""

FAULTY_SENSORLESS_STATE: Final = np.dtype(
    [
        # The controller without the fault.
        ("controller", SENSORLESS_STATE),
        # What is wrong, 0 for nothing, and the observer's gain without rotation (1/s).
        ("fault", np.int64),
        ("still_gain", np.float64),
    ],
    align=True,
)
"""State of a controller with a fault."""


@inlined
def _alter_before(state: Any) -> None:
    """Change the controller's state before a step."""
    controller, fault = state.controller, state.fault
    machine = controller.machine
    if fault == NEWER_VOLTAGE:
        machine.along_voltage[machine.delay] = machine.along_voltage[0]
        machine.across_voltage[machine.delay] = machine.across_voltage[0]
    elif fault == UNSIGNED_GAIN:
        controller.still_gain = state.still_gain + 2.0 * SPEED_GAIN * min(controller.speed, 0.0)
    elif fault == STANDSTILL_PRESUMED and controller.mode == WATCHING:
        controller.magnitudes = 0.0
    elif fault == FIELD_FOR_EVER and controller.mode == RAMPING:
        controller.age = 0
    elif fault == TURNS_FORWARD and controller.mode == WATCHING:
        controller.turned = abs(controller.turned)


@inlined
def step_faulty(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period, with the state's fault."""
    controller = state.controller
    _alter_before(state)
    reference = sense.reference
    if state.fault == STARTS_FORWARD and controller.mode in (ALIGNING, RAMPING):
        sense.reference = abs(reference)
    step_state(controller, sense, command)
    sense.reference = reference
    if state.fault == ANGLE_NEGATED:
        command.angle = -command.angle
    elif state.fault == ELECTRICAL_ANGLE:
        command.angle *= controller.machine.pole_pairs
    elif state.fault == LATE_ANGLE:
        command.angle -= command.speed * controller.machine.control_period
    elif state.fault == LOSS_UNTOLD:
        command.fault = 0


@cache
def faulty_sensorless_step() -> Any:
    """Return the step of a controller with a fault, compiled; the caller must retain the object."""
    signature = step_signature(FAULTY_SENSORLESS_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_faulty(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)
