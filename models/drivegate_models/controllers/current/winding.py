"""A regulator that is wound up in vain, for more current than the angle lets flow: what tells it, and the way back."""

from __future__ import annotations

from math import inf
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import CHANGED
from drivegate_models.controllers.current.protection import (
    SLACK,
    STARVED,
    begin_settling,
    give_step_back,
    walk_back,
)
from drivegate_models.controllers.current.state import HOLDING, SETTLING
from drivegate_models.controllers.current.unrest import is_sagging

# With a band the torque climbs in jumps, up which the regulator creeps to its limit within seconds; the least of it
# over the current limit of the drive tuned on (A).
_CREEP = 1.15
_CREEP_LEAST = 0.15 / 26.0
# Times what the last good angle took that is much more.
_GROWN = 1.1
# The same from which on a speed that is back would overshoot for long.
_OVERSHOOTING = 2.0
# The same creep before any good angle is known: an integral that grows for no more current.
_WINDING = 0.005
_IDLE = 0.002
_WOUND = 3


@inlined
def winds_up(state: Any, power: float) -> bool:
    """Return whether the integral has grown over a decision interval for no more current.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, with what both were in the interval before.
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        By more than noise.
    """
    grown = state.integral - state.last_integral > _WINDING * state.current_limit
    winds: bool = grown and abs(power - state.last_power) < _IDLE * power
    return winds


@inlined
def is_creeping(state: Any, power: float, share: float) -> bool:
    """Return whether the regulator winds up in vain: more current reference for no more current.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, with what was needed at the last good angle.
    power : float
        Mean current sum of the decision interval (A).
    share : float
        Share of the current sum beyond which it is more current.

    Returns
    -------
    bool
        False as long as no good angle is known, and well above it.
    """
    near = state.offset < state.good_offset + state.first_step
    known = state.good_power
    if state.mode == HOLDING and state.rest_power < inf:
        # What was read when the speed was calm is known better than what the last step left.
        known = max(known, state.rest_power)
    creeping: bool = (
        near
        and state.integral > _CREEP * state.good_integral + _CREEP_LEAST * state.current_limit
        and power < (1.0 + share) * known
    )
    return creeping


@inlined
def is_wound(state: Any, power: float) -> bool:
    """Return whether the regulator asks for far more current than flows.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        About its integral.
    """
    wound: bool = state.integral > STARVED * power / state.conducting_phases + SLACK * state.current_limit
    return wound


@inlined
def has_cost_torque(state: Any, power: float, fall: float) -> bool:
    """Return whether the last step has lost the torque: less current flows, and more of it is asked for.

    A lighter load would take less current reference too. Nor would it let the speed sag: where that does and the
    reference has grown much, any fall of the current sum tells.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).
    fall : float
        Share by which one step of this search lessens the current sum at most.

    Returns
    -------
    bool
        False unless the step was one toward less angle.
    """
    if state.moved >= 0.0 or state.integral <= state.good_integral:
        return False
    explained = 0.0 if state.integral > _GROWN * state.good_integral and is_sagging(state) else fall
    less: bool = power < (1.0 - explained) * state.good_power
    return less


@inlined
def unwind_when_back(state: Any) -> bool:
    """Unwind a regulator once the speed that was lost is back, since it would overshoot.

    Returns
    -------
    bool
        Whether it was wound up; once for a loss of speed.
    """
    back = state.mode == SETTLING and state.lost_speed < inf and state.error <= 0.0
    if not back or state.integral <= _OVERSHOOTING * state.good_integral:
        return False
    state.integral = state.good_integral
    begin_settling(state)
    state.lost_speed = inf
    return True


@inlined
def unwind(state: Any, power: float) -> bool:
    """Unwind a regulator that asks for more current than flows, and give angle back where the speed sags.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        Whether it was wound up.
    """
    if state.winding >= _WOUND:
        # The reference is beyond what the angle lets flow; without a good angle known, the current counts.
        flowing = power / state.conducting_phases
        known = max(flowing, state.good_integral) if state.good_power < inf else flowing
        state.integral = min(state.integral, known)
        angle = state.first_step
    elif is_creeping(state, power, 0.5 * CHANGED):
        state.integral = state.good_integral
        angle = 0.5 * state.first_step
    else:
        return False
    if not is_sagging(state):
        return True
    if state.moved < 0.0:
        # That step is to blame, so it is given back whole.
        give_step_back(state, max(angle, -state.moved))
    else:
        walk_back(state, angle, True)
    return True
