"""What a search for the advance angle watches from decision to decision: unrest, noise, creeping, a changed load.

The reference and the correct controllers of other designs share it; they differ in where the angle goes next.
"""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.controllers.protection import (
    HOLDING,
    SEARCHING,
    SETTLING,
    SLACK,
    SMALLEST_STEP,
    STARVED,
    STEPPED_OFF,
    begin_settling,
    forbid,
    rearm,
    walk_back,
)

WAITING: Final = 0
"""What the search has to do: nothing."""
BEGINNING: Final = 1
"""What the search has to do: take its first step since the current sum repeats."""
CONTINUING: Final = 2
"""What the search has to do: go on from its last step."""

LOAD_CHANGED: Final = 0.12
"""Share of the current sum beyond which a search by steps of a degree takes a difference for another load."""
EXACT: Final = 1e-9
"""Greatest error of a speed that an encoder shows as exact by chance (rad/s): by rounding alone."""
JOLT: Final = 0.5
"""Share of k1 beyond which a search by steps of a degree takes a loss of speed for another load."""

# The greatest current sum, and the limit, of the drive that currents are tuned on (A): here they become shares.
_TUNED_SUM = 104.0
_TUNED_LIMIT = 26.0
_SETTLED = 0.01
# A load that is still coming on may look settled once.
_SETTLED_INTERVALS = 2
_CHANGED = 0.03
# Of what the current sum was where the search came to rest: steps off the edge cost a little, and save nothing.
_LESS = 0.01
_MORE = 0.02
_EITHER_WAY = 0.4 / _TUNED_SUM
_EITHER_WAY_NEAR = 0.2 / _TUNED_SUM
_EITHER_WAY_STEADY = 0.3 / _TUNED_SUM
# More than the way back to the initial angle explains.
_HEAVIER_LOAD = 1.6
_SMALLEST_POWER = 1.0 / _TUNED_SUM
# Of k1, and over the calmest error: the steps of an encoder alone are no sign of the edge.
_UNEASY = 0.1
_CALM = 1.5
# Of the current that the regulator adds, in as many phases as conduct.
_ANSWER = 0.5
# With a band the torque climbs in jumps, up which the regulator creeps to its limit within seconds.
_CREEP = 1.15
_CREEP_LEAST = 0.15 / _TUNED_LIMIT
_RESTLESS = 0.003
# The same creep before any good angle is known: an integral that grows for no more current.
_WINDING = 0.005
_IDLE = 0.002
_WOUND = 3


@inlined
def greatest_current_sum(state: Any) -> float:
    """Return the current sum with every conducting phase at the limit.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.

    Returns
    -------
    float
        Current sum (A).
    """
    full: float = state.conducting_phases * state.current_limit
    return full


@inlined
def begin_holding(state: Any, power: float) -> None:
    """Rest at the angle found.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power : float
        Current sum found there (A).
    """
    state.mode = HOLDING
    state.held_power = power
    state.rest_power = inf
    # Without a step before it, the angle held is the only good one known.
    if state.good_power == inf:
        state.good_offset = state.offset
        state.good_integral = state.integral
        state.good_power = power
    state.moved = 0.0
    state.quiet = 0


@inlined
def is_uneasy(state: Any) -> bool:
    """Return whether the speed varied by more than sensors and regulator explain.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state; the calmest decision interval since the last change bounds what they explain.

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    uneasy: bool = state.worst_error > _UNEASY * state.speed_tolerance + _CALM * state.calm_error
    return uneasy


@inlined
def noise_of_regulator(state: Any) -> float:
    """Return what the regulator's answer to the speed sensor's errors makes of the power.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.

    Returns
    -------
    float
        Current sum (A).
    """
    # A greater error is no noise but a speed about to be lost.
    error = min(state.calm_error, _UNEASY * state.speed_tolerance)
    noise: float = _ANSWER * state.conducting_phases * state.proportional * error
    return noise


@inlined
def noise_of_power(state: Any) -> float:
    """Return what the converter, and the regulator's answer to the speed sensor's errors, make of the power.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.

    Returns
    -------
    float
        Current sum (A).
    """
    noise: float = state.least_change + noise_of_regulator(state)
    return noise


@inlined
def is_creeping(state: Any, power: float) -> bool:
    """Return whether the regulator winds up in vain: more current reference for no more current.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state, with what was needed at the last good angle.
    power : float
        Mean current sum of the decision interval (A).

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
        and power < (1.0 + 0.5 * _CHANGED) * known
    )
    return creeping


@inlined
def differs(state: Any, power: float, known: float, share: float, either_way: float) -> bool:
    """Return whether a current sum is another one than a known one.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power, known : float
        Mean current sum of the decision interval, and the one that it is compared with (A).
    share, either_way : float
        Difference that means nothing: a share of the current sum, and one of the greatest current sum (1).

    Returns
    -------
    bool
        Whether they differ by more than both together.
    """
    differ: bool = abs(power - known) > share * power + either_way * greatest_current_sum(state)
    return differ


@inlined
def load_has_changed(state: Any, power: float, fall: float, rise: float) -> bool:
    """Return whether the current sum differs from that of the last good angle by more than angles explain.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power : float
        Mean current sum of the decision interval (A).
    fall, rise : float
        What steps toward less and toward more angle explain, as shares of the current sum.

    Returns
    -------
    bool
        False as long as no good angle is known, and away from it.
    """
    # Farther off, the angle alone may explain the difference.
    near = abs(state.offset - state.good_offset) <= 3.0 * state.first_step
    share = fall if power < state.good_power else rise
    changed: bool = near and differs(state, power, state.good_power, share, _EITHER_WAY_NEAR)
    return changed and state.good_power < inf


@inlined
def is_another_load(state: Any, power: float, known: float) -> bool:
    """Return whether the current sum at one and the same angle tells of another load.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power, known : float
        Mean current sum of the decision interval, and the one before at this angle (A).

    Returns
    -------
    bool
        Whether they differ by more than a steady load's do.
    """
    return differs(state, power, known, _CHANGED, _EITHER_WAY_STEADY)


@inlined
def decide_holding(state: Any, power: float, change: float) -> None:
    """Watch what was found: search anew after a change of load, and keep off an edge that is too near.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power, change : float
        Mean current sum of the decision interval, and its change from the one before (A).
    """
    uneasy = is_uneasy(state)
    # While the speed comes back from the last step, the current sum is not yet that of the rest.
    if state.rest_power == inf and state.quiet > 0 and not uneasy:
        state.rest_power = power
    # A load that comes or goes slowly moves `held_power` along, step off the edge by step.
    share = _LESS if power < state.rest_power else _MORE
    moved_on = state.rest_power < inf and differs(state, power, state.rest_power, share, _EITHER_WAY)
    changed = moved_on or is_another_load(state, power, state.held_power)
    if is_creeping(state, power):
        state.integral = state.good_integral
        walk_back(state, state.first_step if uneasy else SMALLEST_STEP, True)
    elif state.quiet <= 0:
        # The interval of its own last step is not judged.
        state.quiet = 1
        if not changed:
            state.held_power = power
    elif changed:
        rearm(state)
    elif uneasy or abs(change) > _RESTLESS * power + noise_of_power(state):
        # The optimum may lie on the edge itself: a little above it costs less than a new search.
        forbid(state)
        state.offset += SMALLEST_STEP
        state.quiet = STEPPED_OFF


@inlined
def is_jolted(state: Any, jolt: float) -> bool:
    """Return whether the speed is off by more than a step of the search makes of it.

    A step that costs speed is given back at once; any other jolt is the load's.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    jolt : float
        Speed that one step of this search costs at most, as a share of k1.

    Returns
    -------
    bool
        False unless the search moves.
    """
    jolted: bool = state.worst_error > jolt * state.speed_tolerance + _CALM * state.calm_error
    return jolted and state.mode == SEARCHING


@inlined
def is_read_too_soon(state: Any, power: float, change: float) -> bool:
    """Return whether the current sum may mislead, since the speed still comes back from a step.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power, change : float
        Mean current sum of the decision interval, and its change by the step (A).

    Returns
    -------
    bool
        False where the sum falls anyway, which leads on.
    """
    falling = change < -max(state.power_tolerance * power, noise_of_power(state))
    # Small steps do not disturb the speed; after one of them unrest is a sign of the edge.
    large = abs(state.moved) >= state.first_step
    return large and not falling and is_uneasy(state)


@inlined
def rearm_unless_repeated(state: Any) -> bool:
    """Start anew since the load seems to have changed, unless that was so at this angle, or beyond, before.

    A load changes at any angle. What happens again where the search has been is what the steps there do.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.

    Returns
    -------
    bool
        Whether the search starts anew.
    """
    offset = state.offset
    if state.moved != 0.0 and offset >= state.jolted_at - 1.5 * state.first_step:
        return False
    rearm(state)
    state.jolted_at = offset
    return True


@inlined
def may_step_farther(state: Any, power: float, change: float) -> bool:
    """Return whether twice the last step would still be told from another load.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state.
    power, change : float
        Mean current sum of the decision interval, and its change by the step (A).

    Returns
    -------
    bool
        By what the step has done to current sum and speed, which are in proportion to it.
    """
    calm = min(state.calm_error, state.worst_error)
    jolts = 2.0 * state.worst_error - calm > JOLT * state.speed_tolerance + _CALM * calm
    return not jolts and 2.0 * abs(change) <= LOAD_CHANGED * power


@inlined
def remember(state: Any, power: float) -> None:
    """Keep of a decision interval how calm the speed was, and whether the integral grew for no more current.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated.
    power : float
        Mean current sum of the decision interval (A).
    """
    # An encoder may show a speed as exact by chance, which is no measure of its steps.
    if state.worst_error > EXACT:
        state.calm_error = min(state.calm_error, state.worst_error)
    winding = state.integral - state.last_integral > _WINDING * state.current_limit
    winding = winding and abs(power - state.last_power) < _IDLE * power
    state.winding = state.winding + 1 if winding else 0
    state.last_integral = state.integral
    state.last_power = power


@inlined
def watch_search(state: Any, fall: float, rise: float, jolt: float) -> tuple[int, float]:
    """Make the part of a decision that is the same for every search.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        Updated; its decision interval is complete, its mean current sum becomes `last_power`.
    fall, rise : float
        Changes of the current sum that one step of this search explains, as shares; more is another load.
    jolt : float
        Speed that one step of this search costs at most, as a share of k1; more is another load.

    Returns
    -------
    work : int
        `WAITING`, `BEGINNING` or `CONTINUING`: what is left to the search itself.
    change : float
        Change of the mean current sum from the interval before (A).
    """
    power = state.power_sum / state.count
    remember(state, power)
    if power > _HEAVIER_LOAD * state.forbidden_power:
        # It was this load that lost the torque, not the angle with the load of before.
        state.forbidden = -inf
    regulated = state.worst_error <= state.speed_tolerance and state.saturated == 0
    change = power - state.old_power
    state.old_power = power
    if state.mode == HOLDING:
        decide_holding(state, power, change)
        return WAITING, change
    if state.winding >= _WOUND and is_uneasy(state):
        # The reference is beyond what the angle lets flow; without a good angle known, the current counts.
        state.integral = min(state.integral, power / state.conducting_phases)
        walk_back(state, state.first_step, True)
        return WAITING, change
    if is_creeping(state, power) and is_uneasy(state):
        state.integral = state.good_integral
        walk_back(state, 0.5 * state.first_step, True)
        return WAITING, change
    # A current sum with the speed off its reference says nothing about the angle.
    if not regulated or power < _SMALLEST_POWER * greatest_current_sum(state):
        begin_settling(state)
        return WAITING, change
    settled = abs(change) <= _SETTLED * power
    # Back at the last good angle, the angle explains no more than while one is held.
    back = abs(state.offset - state.good_offset) <= 0.5 * state.first_step and state.good_power < inf
    if state.mode == SETTLING and settled and back and is_another_load(state, power, state.good_power):
        rearm(state)
        return WAITING, change
    if state.moved < 0.0 and state.integral > state.good_integral and power < (1.0 - fall) * state.good_power:
        # A lighter load would take less current reference too: this step has lost the torque.
        state.integral = state.good_integral
        walk_back(state, 0.5 * state.first_step - state.moved, True)
        return WAITING, change
    seems = (settled or state.mode != SETTLING) and load_has_changed(state, power, fall, rise)
    if (seems or is_jolted(state, jolt)) and rearm_unless_repeated(state):
        return WAITING, change
    if state.mode == SETTLING:
        # A load that is still coming on would be taken for the effect of the first step.
        wound = state.integral > STARVED * power / state.conducting_phases + SLACK * state.current_limit
        state.quiet = state.quiet + 1 if settled else 0
        if state.quiet < _SETTLED_INTERVALS or wound or is_uneasy(state):
            return WAITING, change
        state.quiet = 0
        state.mode = SEARCHING
        state.climb = 0.5 * state.first_step
        state.regained = -inf
        return BEGINNING, change
    if state.waited == 0 and is_read_too_soon(state, power, change):
        state.waited = 1
        state.old_power = power - change
        return WAITING, change
    state.waited = 0
    return CONTINUING, change
