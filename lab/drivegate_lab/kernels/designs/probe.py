"""Probe of an angle: approach it in steps that can be reverted, and wait until its current sum repeats."""

from __future__ import annotations

from math import ceil, radians
from typing import Any

from drivegate_lab.kernels.designs.state import SWEEP
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.forbidden_angle import MARGIN
from drivegate_models.controllers.current.protection import take_step
from drivegate_models.controllers.current.unrest import current_sum_noise, is_speed_unsteady

_IMPROVEMENTS = 3
_LONGEST_RISE = radians(2.9)
_REACHED = 1e-9
_REPEATED = 0.003
_LONGEST_WAIT = 3


@inlined
def is_reached(state: Any) -> bool:
    """Return True if the angle has reached the probe."""
    reached: bool = abs(state.target - state.controller.offset) < _REACHED
    return reached


@inlined
def is_read(state: Any, change: float) -> bool:
    """Return True if the current sum at the angle just reached is reliable.

    `change` is the change of the mean current sum since the last decision (A).
    """
    state.waited += 1
    current_sum = state.controller.last_power
    repeated = abs(change) <= _REPEATED * current_sum + current_sum_noise(state.controller)
    repeated = repeated and not is_speed_unsteady(state.controller)
    # A sweep does not stop at its angles.
    sweeps = state.design == SWEEP and state.tabled == 0
    patience = 1 if sweeps and state.finished == 0 and state.confirming == 0 else _LONGEST_WAIT
    read: bool = repeated or state.waited >= patience
    return read


@inlined
def aim(state: Any, offset: float) -> None:
    """Set the next probe to an offset (rad electrical), or to just above the angles that have lost the torque."""
    state.target = max(offset, state.controller.forbidden + MARGIN)
    state.waited = 0


@inlined
def approach(state: Any) -> None:
    """Step toward the probe: down in steps small enough to be reverted, up in longer steps."""
    controller = state.controller
    distance = state.target - controller.offset
    longest = _LONGEST_RISE
    if distance < 0.0:
        longest = controller.step
        controller.improvements += 1
        if controller.improvements >= _IMPROVEMENTS and controller.step < 2.0 * controller.first_step:
            controller.step = 2.0 * controller.step
            controller.improvements = 0
    # Use equal steps: reverting a tiny last step would not be enough.
    steps = max(ceil(abs(distance) / longest - _REACHED), 1)
    take_step(controller, controller.last_power, distance / steps)
