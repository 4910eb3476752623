"""Variations of field-oriented control without a position sensor: what differs before and after each of its steps.

Some are faults, others are correct designs.
"""

from __future__ import annotations

from functools import cache
from math import pi
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.controllers.duty.flux_observer import SPEED_GAIN, place_rotor
from drivegate_models.controllers.duty.foc_sensorless import run_observed, step_state
from drivegate_models.controllers.duty.sensorless_state import (
    ALIGNING,
    RAMPING,
    RUNNING,
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

HALF_TURN_OFF: Final = 11
"""The field is handed over with the rotor half a turn off."""
FROM_ZERO: Final = 12
"""The speed regulator begins at handover without a torque."""
STALL_BELIEVED: Final = 13
"""A rotor that stands still while the observed flux is right is not lost."""
COASTS: Final = 14
"""A shaft whose reference has changed its sense is left to itself below the least speed."""
BY_OBSERVER: Final = 15
"""Correct: the observed angle drives a rotor as soon as it is aligned, and no current vector turns it."""

# Least observed speed of a start by the observer over the least one, and time that it has to turn beyond that of the
# ramp, in periods of the swing.
_TURNING: Final = 0.1
_WAITED: Final = 6.0

VARIED_SENSORLESS_STATE: Final = np.dtype(
    [
        # The controller without the variation.
        ("controller", SENSORLESS_STATE),
        # What differs, 0 for nothing, and the observer's gain without rotation (1/s).
        ("variation", np.int64),
        ("still_gain", np.float64),
        # Control periods since the rotor was aligned, while it gets its time to turn; else 0.
        ("starting", np.int64),
    ],
    align=True,
)
"""State of a controller with a variation."""


@inlined
def _alter_handover(controller: Any, variation: int) -> None:
    """Change the state with which the observed angle takes over."""
    if variation == HALF_TURN_OFF:
        angle = controller.angle + pi
        place_rotor(controller, angle, controller.speed, controller.along_before, controller.across_before)
    elif variation == FROM_ZERO:
        controller.machine.speed_integral = 0.0
        controller.machine.torque = 0.0


@inlined
def _coast(controller: Any, sense: Any) -> None:
    """Let a shaft coast at low speed whose reference has the other sense."""
    forward = 1.0 if controller.speed >= 0.0 else -1.0
    wanted = forward * controller.machine.pole_pairs * sense.reference < 0.5 * controller.least_speed
    slow = abs(controller.speed) < 1.2 * controller.least_speed
    if controller.machine.regulates_speed == 1 and controller.mode == RUNNING and slow and wanted:
        controller.mode = WATCHING
        controller.age = 0
        controller.agreed = 0
        controller.turned = 0.0
        controller.magnitudes = 0.0


@inlined
def _start_by_observer(state: Any) -> None:
    """Have a rotor that starts turn with the sense of the start, and not be lost before it had time to."""
    controller = state.controller
    ahead = controller.sense_of_start * controller.speed
    ramp = controller.handover_speed / controller.acceleration + _WAITED * controller.swing_period
    if ahead > controller.handover_speed or state.starting * controller.machine.control_period > ramp:
        state.starting = 0
        return
    state.starting += 1
    controller.lost = 0
    controller.speed = controller.sense_of_start * max(ahead, _TURNING * controller.least_speed)


@inlined
def _alter_before(state: Any, sense: Any) -> None:
    """Change the controller's state before a step."""
    controller, variation = state.controller, state.variation
    if state.starting > 0:
        _start_by_observer(state)
    machine = controller.machine
    if variation == NEWER_VOLTAGE:
        machine.along_voltage[machine.delay] = machine.along_voltage[0]
        machine.across_voltage[machine.delay] = machine.across_voltage[0]
    elif variation == UNSIGNED_GAIN:
        controller.still_gain = state.still_gain + 2.0 * SPEED_GAIN * min(controller.speed, 0.0)
    elif variation == STANDSTILL_PRESUMED and controller.mode == WATCHING:
        controller.magnitudes = 0.0
    elif variation == FIELD_FOR_EVER and controller.mode == RAMPING:
        controller.age = 0
    elif variation == TURNS_FORWARD and controller.mode == WATCHING:
        controller.turned = abs(controller.turned)
    elif variation == STALL_BELIEVED and abs(controller.flux_error) < 0.5:
        controller.lost = 0
    elif variation == COASTS:
        _coast(controller, sense)


@inlined
def step_varied(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period, with the state's variation."""
    controller, variation = state.controller, state.variation
    _alter_before(state, sense)
    reference, mode = sense.reference, controller.mode
    if variation == STARTS_FORWARD and controller.mode in (ALIGNING, RAMPING):
        sense.reference = abs(reference)
    step_state(controller, sense, command)
    sense.reference = reference
    if mode == RAMPING and controller.mode == RUNNING:
        _alter_handover(controller, variation)
    elif mode == ALIGNING and controller.mode == RAMPING and variation == BY_OBSERVER:
        run_observed(controller, 0.0)
        state.starting = 1
    if variation == ANGLE_NEGATED:
        command.angle = -command.angle
    elif variation == ELECTRICAL_ANGLE:
        command.angle *= controller.machine.pole_pairs
    elif variation == LATE_ANGLE:
        command.angle -= command.speed * controller.machine.control_period
    elif variation == LOSS_UNTOLD:
        command.fault = 0


@cache
def varied_sensorless_step() -> Any:
    """Return the step of a controller with a variation, compiled; the caller must retain the object."""
    signature = step_signature(VARIED_SENSORLESS_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_varied(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)
