"""Detection and recovery of a wound-up regulator, whose reference exceeds the current that can flow at the angle."""

from __future__ import annotations

from math import inf
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import CHANGED
from drivegate_models.controllers.current.modes import begin_settling
from drivegate_models.controllers.current.protection import SLACK, STARVED, back_off, revert_step
from drivegate_models.controllers.current.state import HOLDING, SETTLING
from drivegate_models.controllers.current.unrest import is_sagging, is_speed_returning

# With a hysteresis band the torque rises in jumps, up which the regulator creeps to its limit within seconds. The
# minimum creep is a share of the current limit, from the drive tuned on (A).
_CREEP = 1.15
_CREEP_LEAST = 0.15 / 26.0
# Growth of the current reference that is large, relative to the last good angle's.
_GROWN = 1.1
# The same growth from which a recovered speed would overshoot for long.
_OVERSHOOTING = 2.0
# The same creep before a good angle is known: an integral that grows without more current.
_WINDING = 0.005
_IDLE = 0.002
_WOUND = 3


@inlined
def winds_up(state: Any, current_sum: float) -> bool:
    """Return True if the integral has grown over a decision interval without more current, beyond noise.

    `current_sum` is the mean of the interval (A).
    """
    grown = state.integral_growth > _WINDING * state.current_limit
    winding_up: bool = grown and abs(current_sum - state.last_power) < _IDLE * current_sum
    return winding_up


@inlined
def is_creeping(state: Any, current_sum: float, share: float) -> bool:
    """Return True if the regulator winds up in vain compared with the last good angle.

    The current reference has grown, but the mean current sum of the interval (A) has not grown by more than
    `share`. False while no good angle is known, and well above it.
    """
    near = state.offset < state.good_offset + state.first_step
    known = state.good_power
    if state.mode == HOLDING and state.rest_power < inf:
        # A reading at a steady speed is more reliable than the one after the last step.
        known = max(known, state.rest_power)
    creeping: bool = (
        near
        and state.integral > _CREEP * state.good_integral + _CREEP_LEAST * state.current_limit
        and current_sum < (1.0 + share) * known
    )
    return creeping


@inlined
def is_wound_up(state: Any, current_sum: float) -> bool:
    """Return True if the regulator's integral far exceeds the mean current per conducting phase (A)."""
    wound_up: bool = (
        state.integral > STARVED * current_sum / state.conducting_phases + SLACK * state.current_limit
    )
    return wound_up


@inlined
def has_lost_torque(state: Any, current_sum: float, fall: float) -> bool:
    """Return True if the last step, toward less angle, has lost the torque.

    Then less current flows although the current reference is higher. A lighter load would reduce the current
    reference, too, and would not let the speed sag. If the speed sags and the reference has grown much, any fall of
    the current sum is conclusive. Otherwise the fall must exceed `fall`, the maximum share by which one step of
    this search reduces the current sum.
    """
    if state.moved >= 0.0 or state.integral <= state.good_integral:
        return False
    explained = 0.0 if state.integral > _GROWN * state.good_integral and is_sagging(state) else fall
    less: bool = current_sum < (1.0 - explained) * state.good_power
    return less


@inlined
def is_unwinding(state: Any) -> bool:
    """Return True if the regulator still adds to what the last good angle needed, after a loss of speed."""
    unwinding: bool = state.lost_speed < inf and state.integral > _GROWN * state.good_integral
    return unwinding


@inlined
def current_in_use(state: Any, current_sum: float) -> float:
    """Return the current to which a wound-up regulator unwinds (A): that of the last good angle, or more if it flows.

    `current_sum` is the mean of the interval (A). What flows has not wound up in vain: the load has grown.
    """
    flowing: float = current_sum / state.conducting_phases
    return max(flowing, float(state.good_integral)) if state.good_power < inf else flowing


@inlined
def unwind_after_recovery(state: Any, current_sum: float) -> bool:
    """Unwind the regulator once lost speed has returned, to avoid overshoot; return True if it was wound up.

    This happens once per loss of speed. `current_sum` is the mean of the interval (A).
    """
    back = state.mode == SETTLING and state.lost_speed < inf and state.error <= 0.0
    if not back or state.integral <= _OVERSHOOTING * state.good_integral:
        return False
    state.integral = min(state.integral, current_in_use(state, current_sum))
    begin_settling(state)
    state.lost_speed = inf
    return True


@inlined
def unwind(state: Any, current_sum: float) -> bool:
    """Unwind a regulator whose reference exceeds the current that flows; return True if it was wound up.

    If the speed sags, also revert angle. `current_sum` is the mean of the interval (A).
    """
    if state.winding >= _WOUND:
        # The reference exceeds the current that can flow at this angle.
        state.integral = min(state.integral, current_in_use(state, current_sum))
        angle = state.first_step
    elif is_creeping(state, current_sum, 0.5 * CHANGED) and not is_speed_returning(state):
        state.integral = state.good_integral
        angle = 0.5 * state.first_step
    else:
        return False
    if not is_sagging(state):
        return True
    if state.moved < 0.0:
        # The last step caused it, so it is reverted completely.
        revert_step(state, max(angle, -state.moved))
    else:
        back_off(state, angle, True)
    return True
