"""Trying an angle: going there by steps that can be given back, and waiting until its current sum repeats."""

from __future__ import annotations

from math import ceil, radians
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.designs.state import SWEEP
from drivegate_models.controllers.current.forbidden_angle import MARGIN
from drivegate_models.controllers.current.protection import take_step
from drivegate_models.controllers.current.unrest import is_uneasy, noise_of_power

_IMPROVEMENTS = 3
_LONGEST_RISE = radians(2.9)
_REACHED = 1e-9
_REPEATED = 0.003
_LONGEST_WAIT = 3


@inlined
def is_reached(state: Any) -> bool:
    """Return whether the angle has reached the probe.

    Returns
    -------
    bool
        About the present angle.
    """
    reached: bool = abs(state.target - state.controller.offset) < _REACHED
    return reached


@inlined
def is_read(state: Any, change: float) -> bool:
    """Return whether the current sum at the angle just reached can be believed.

    Parameters
    ----------
    change : float
        Change of the mean current sum since the last decision (A).

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    state.waited += 1
    power = state.controller.last_power
    repeated = abs(change) <= _REPEATED * power + noise_of_power(state.controller)
    repeated = repeated and not is_uneasy(state.controller)
    # A sweep does not stop at its angles.
    sweeps = state.design == SWEEP and state.tabled == 0
    patience = 1 if sweeps and state.finished == 0 and state.confirming == 0 else _LONGEST_WAIT
    read: bool = repeated or state.waited >= patience
    return read


@inlined
def aim(state: Any, offset: float) -> None:
    """Take the next probe at an angle, or just above what has lost the torque.

    Parameters
    ----------
    offset : float
        Offset from the initial angle (rad electrical).
    """
    state.target = max(offset, state.controller.forbidden + MARGIN)
    state.waited = 0


@inlined
def approach(state: Any) -> None:
    """Take a step toward the probe: down by as little as a walk back can return, up by a longer one."""
    controller = state.controller
    distance = state.target - controller.offset
    longest = _LONGEST_RISE
    if distance < 0.0:
        longest = controller.step
        controller.improvements += 1
        if controller.improvements >= _IMPROVEMENTS and controller.step < 2.0 * controller.first_step:
            controller.step = 2.0 * controller.step
            controller.improvements = 0
    # Equal steps: a last one that were tiny would be no way back.
    steps = max(ceil(abs(distance) / longest - _REACHED), 1)
    take_step(controller, controller.last_power, distance / steps)
