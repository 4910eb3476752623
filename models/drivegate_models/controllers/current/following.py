"""Operation in which the angle regulates the speed while the current is not limited.

Where the peak EMF clearly exceeds the supply, this is the operation of least current sum: the EMF limits the current
there, and what a regulator saves at a greater angle costs more than a smaller angle does. Below, a limited current at a
greater angle may need less. The search then goes upward from this operation, and the least of all that it has found is
kept.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.controllers.current.another_load import (
    EITHER_WAY_NEAR,
    NEAR,
    differs,
)
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.forbidden_angle import LIGHT, allow_all_angles
from drivegate_models.controllers.current.modes import (
    SURE,
    begin_following,
    begin_settling,
    forget_good_angle,
    hold_angle,
    may_follow,
    stop_following,
)
from drivegate_models.controllers.current.state import SMALLEST_STEP
from drivegate_models.controllers.current.unrest import is_speed_unsteady

# Rates of the speed regulation by the angle and of its integral, on the drive tuned on (1/s).
_BANDWIDTH = 40.0
_INTEGRAL_RATE = 5.0
# Power that an unlimited current gains with the angle, over rated power (1/rad electrical).
_POWER_PER_ANGLE = 1.4
# Least multiple of the slope of a load of rated power, whose torque grows as the speed falls.
_LEAST_SLOPE = 3.0
# Time in which the current reference rises from zero to its limit, on the drive tuned on (s).
_FREEING_TIME = 0.1
# Share of k1: only at a greater speed the current reference stops rising.
_TOO_FAST = 0.3
# Up to a speed error of k1 the gain is reduced, by this factor in each interval and to this share. At the full gain,
# each step of an encoder's speed moves the angle.
_EASED = 0.8
_LEAST_GAIN = 0.05
# Share of the gain below which the integral is slower, too, so that the regulation stays damped; its inverse.
_INTEGRAL_SLOWER = 4.0
# Greatest angle above the initial one.
_FARTHEST = radians(10.0)
# Intervals in which the current sum repeats, before it is the one at rest.
_STEADY_INTERVALS = 3
# Intervals after which a current sum that does not repeat counts as none.
_MOST_INTERVALS = 20
# Share of the current sum by which a limited current must need less. The angle gives the torque at any current.
_LESS = 0.005
# Share that a limited current saves at most with each first step above the regulated angle.
_SAVED = 0.02
# Current reference over the mean current of a conducting phase, where a current begins to be limited.
_PEAK = 1.1
# Current sums, relative to the one at rest, that indicate another load.
_LIGHTER = 0.88
_HEAVIER = 1.2


@inlined
def reset_following(state: Any, nameplate: Any, rate: float, regulation: float, load_slope: float) -> None:
    """Write the constants of the speed regulation by the angle.

    `rate` is the drive's electrical frequency over that of the drive tuned on, `regulation` the same of the speed
    regulator (1), and `load_slope` the slope of a load of rated power at base speed, over the inertia (1/s).
    """
    bandwidth = _BANDWIDTH * regulation
    state.angle_proportional = nameplate.inertia * bandwidth / (_POWER_PER_ANGLE * nameplate.rated_power)
    state.angle_integral_step = (
        state.angle_proportional * (_INTEGRAL_RATE * regulation) * nameplate.control_period
    )
    state.least_angle_gain = _LEAST_SLOPE * load_slope / bandwidth
    state.freed_step = nameplate.current_limit * nameplate.control_period * rate / _FREEING_TIME
    state.matched_speed = nameplate.half_supply_voltage / nameplate.emf_constant
    state.emf_over_supply = 0.0
    # Current regulators of rotor currents, below a reference and an angle, do not let the EMF limit the current.
    if nameplate.kind == PM_AC:
        state.angle_proportional = 0.0


@inlined
def follow_speed(state: Any, error: float, speed: float) -> float:
    """Regulate the speed by the angle, and return the current reference (A).

    `error` is speed reference minus `speed` (rad/s).
    """
    if error > -_TOO_FAST * state.speed_tolerance:
        state.freed_reference = min(state.freed_reference + state.freed_step, state.current_limit)
    if abs(error) > state.speed_tolerance:
        state.angle_gain = 1.0
    # The torque that an angle adds is a power over the speed.
    ratio = state.base_speed / max(speed, state.base_speed)
    gain = max(state.angle_gain, min(state.least_angle_gain * ratio * ratio, 1.0))
    weighted = gain * speed * error
    slower = min(_INTEGRAL_SLOWER * gain, 1.0)
    state.angle_integral = _within(
        state, state.angle_integral + slower * state.angle_integral_step * weighted
    )
    state.offset = _within(state, state.angle_integral + state.angle_proportional * weighted)
    reference: float = state.freed_reference
    return reference


@inlined
def _within(state: Any, offset: float) -> float:
    """Return an offset (rad electrical) within the range of the regulated angle."""
    within: float = min(max(offset, state.lowest), _FARTHEST)
    return within


@inlined
def decide_following(state: Any, current_sum: float, settled: bool) -> None:
    """Compare it with a limited current once it is steady, and restart the search after a change of load.

    `current_sum` is the mean of the decision interval (A); `settled` is True if it repeats.
    """
    # While the speed is still returning, the current sum may look settled.
    state.quiet = state.quiet + 1 if settled and not is_speed_unsteady(state) else 0
    state.followed_intervals += 1
    state.angle_gain = max(_EASED * state.angle_gain, _LEAST_GAIN)
    if state.angle_integral <= state.lowest + SMALLEST_STEP:
        # Even without advance the torque exceeds the load, so the current must be limited.
        _give_up(state, current_sum)
    elif state.followed_power < inf:
        ratio = current_sum / state.followed_power
        if ratio < _LIGHTER or ratio > _HEAVIER:
            stop_following(state, current_sum, True)
    elif state.quiet >= _STEADY_INTERVALS:
        state.followed_power = current_sum
        # Under a light load a limited current needs much more, and its sum has many local minima.
        is_sure = state.emf_over_supply >= SURE or is_current_below(state, LIGHT)
        if state.compared == 0 and not is_sure:
            _search_upward(state, current_sum)
    elif state.followed_intervals >= _MOST_INTERVALS and state.emf_over_supply < SURE:
        _give_up(state, current_sum)


@inlined
def _search_upward(state: Any, current_sum: float) -> None:
    """Search with a limited current from the present angle upward, where it may need less than `current_sum` (A).

    Below, the torque has a greatest value beyond which the regulator would lose it.
    """
    state.compared = 1
    state.integral = min(_PEAK * current_sum / state.conducting_phases, state.current_limit)
    state.forbidden = state.offset
    state.lost_at = state.offset
    state.forbidden_power = current_sum
    forget_good_angle(state)
    state.offset += state.first_step
    state.step = 0.5 * state.first_step
    state.direction = 1.0
    begin_settling(state)


@inlined
def _search_downward(state: Any) -> None:
    """Search from the present angle for the lower edge of a load that seems to have become lighter."""
    allow_all_angles(state)
    state.compared = 0
    state.followed_power = inf
    state.kept_power = inf
    forget_good_angle(state)
    state.step = state.first_step
    state.direction = -1.0
    begin_settling(state)


@inlined
def _give_up(state: Any, current_sum: float) -> None:
    """Regulate by the current again under this load, at the angle known or by a new search.

    `current_sum` is the one that flows (A).
    """
    if state.kept_power < inf:
        # Not held at once, since the speed is off its reference by now.
        state.follows = 0
        _restore_kept(state)
        begin_settling(state)
    else:
        stop_following(state, current_sum, False)


@inlined
def _restore_kept(state: Any) -> None:
    """Set the angle at which the search was before the angle regulated the speed."""
    state.offset = state.kept_offset
    state.integral = state.kept_integral
    forget_good_angle(state)
    # Once: what it needs at rest may be more.
    state.kept_power = inf


@inlined
def tries_following(state: Any, current_sum: float) -> bool:
    """Let the angle regulate the speed from now on and return True, or return False where that needs no less.

    `current_sum` is the mean of the interval (A).
    """
    # At a lower EMF, an optimum that is not at the edge is one of a limited current.
    tries = state.emf_over_supply >= 1.0 and may_follow(state)
    if tries:
        state.kept_offset = state.offset
        state.kept_integral = state.integral
        state.kept_power = current_sum
        begin_following(state)
    return tries


@inlined
def is_lighter_than_followed(state: Any, current_sum: float) -> bool:
    """Return True if a mean current sum (A) is less than an angle just above the regulated one explains.

    There, a limited current needs about as much as the unlimited one does. The load has become lighter while the
    search went upward.
    """
    # Until another angle is forbidden, the regulated one is.
    above = state.compared == 1 and state.forbidden_power == state.followed_power
    if not above or state.lightened == 1:
        return False
    steps = max((state.offset - state.forbidden) / state.first_step, 1.0)
    less = steps <= NEAR and current_sum < state.followed_power
    lighter: bool = less and differs(
        state, current_sum, state.followed_power, steps * _SAVED, EITHER_WAY_NEAR
    )
    return lighter


@inlined
def goes_on(state: Any, current_sum: float) -> bool:
    """Continue, at the end of a search, with an operation that may need less; return False if none is known.

    `current_sum` is the mean of the interval (A).
    """
    if is_lighter_than_followed(state, current_sum):
        # Once: on some drives a limited current saves as much.
        state.lightened = 1
        _search_downward(state)
        return True
    if state.compared == 0:
        return tries_following(state, current_sum)
    # At equal currents, too: the angle gives the torque at any current.
    if state.follows == 1 and state.followed_power * (1.0 - _LESS) < min(current_sum, state.kept_power):
        begin_following(state)
        return True
    if current_sum <= (1.0 + _LESS) * state.kept_power:
        return False
    kept_power = state.kept_power
    _restore_kept(state)
    hold_angle(state, kept_power)
    return True
