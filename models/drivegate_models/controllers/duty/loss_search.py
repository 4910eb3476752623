"""The currents of least loss, by trying: the one along the magnet's axis moves to where the link gives less power."""

from __future__ import annotations

from math import ceil, isnan, nan, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined

SETTLING: Final = 0.03
"""Time that a new current is given before the power is looked at (s)."""
LOOKING: Final = 0.02
"""Time over which the power is averaged, or more: a whole number of sixths of the field's turn, as it ripples (s)."""
_LONGEST = 0.06

# First and last step over the current limit.
_FIRST_STEP = 0.06
_LAST_STEP = 0.002
# Least fall of the power over the power, for a step that adds current: the torque, which is not seen, changes by as
# much in a step, and a search that took this for loss would drift.
_LEAST_GAIN = 1e-5
# Steps one after the other that were right, from which on they grow: where a search narrows down there are no more.
_FAR = 3
# Change of torque over the greatest one, and of speed over itself, from which on the point of operation is another.
_OTHER_TORQUE = 0.02
_OTHER_SPEED = 0.02


@inlined
def reset_search(state: Any, nameplate: Any) -> None:
    """Write the constants of the search and forget everything else."""
    period = nameplate.control_period
    state.search_settling = int(SETTLING / period)
    state.search_shortest = LOOKING / period
    state.search_longest = _LONGEST / period
    state.search_sixth = pi / 3.0 / (nameplate.pole_pairs * period)
    state.search_inertia = nameplate.inertia / period
    forget_search(state, 0.0, 0.0)


@inlined
def forget_search(state: Any, torque: float, speed: float) -> None:
    """Begin a search anew at a torque (N m) and a speed (rad/s)."""
    state.search_torque = torque
    state.search_speed = speed
    state.search_offset = 0.0
    state.search_step = -_FIRST_STEP * state.current_limit
    state.search_gains = 0
    state.search_power = nan
    _look_anew(state, speed)


@inlined
def _look_anew(state: Any, speed: float) -> None:
    """Give a new current time to settle before its power is looked at."""
    looking = state.search_shortest
    turning = abs(speed)
    if turning * state.search_longest > state.search_sixth:
        sixth = state.search_sixth / turning
        looking = ceil(looking / sixth) * sixth
    state.search_looking = 2 * int(0.5 * min(looking, state.search_longest) + 0.5)
    state.search_count = 0
    state.search_sum = 0.0
    state.search_early = 0.0
    state.search_late = 0.0


@inlined
def _look(state: Any, speed: float, power: float) -> None:
    """Take in the power and the speed of a period."""
    state.search_sum += power
    if 2 * (state.search_count - state.search_settling) > state.search_looking:
        state.search_late += speed
    else:
        state.search_early += speed


@inlined
def _move(state: Any, torque: float) -> None:
    """Take the next step: on while the power falls, further where it keeps falling, else back and half as far.

    While a speed settles, the power into inertia and load changes by more than the loss does. A search that took this
    for its own doing would go where the speed happens to fall, so it is left out.
    """
    pace = (state.search_early + state.search_late) / state.search_looking
    # The means of the two halves of a look are half a look apart.
    half = 0.5 * state.search_looking
    accelerating = state.search_inertia * pace * (state.search_late - state.search_early) / (half * half)
    power = state.search_sum / state.search_looking - accelerating
    if not isnan(state.search_power):
        least_gain = _LEAST_GAIN * abs(power) if state.search_step < 0.0 else 0.0
        if power - torque * (pace - state.search_pace) < state.search_power - least_gain:
            state.search_gains += 1
            factor = 2.0 if state.search_gains >= _FAR else 1.0
        else:
            state.search_gains = 0
            factor = -0.5
        step = factor * state.search_step
        size = min(max(abs(step), _LAST_STEP * state.current_limit), _FIRST_STEP * state.current_limit)
        state.search_step = size if step > 0.0 else -size
    state.search_power = power
    state.search_pace = pace
    state.search_offset += state.search_step
    if state.search_offset > 0.0:
        # No current that strengthens the field is tried.
        state.search_offset = 0.0
        state.search_step = -0.5 * abs(state.search_step)


@inlined
def searched_offset(state: Any, torque: float, speed: float, power: float) -> float:
    """Return what is added to the current along the magnet's axis, in one period of the search for least power.

    Parameters
    ----------
    torque : float
        Wanted (N m).
    speed : float
        Of the shaft (rad/s).
    power : float
        Given by the link in the period just ended (W).

    Returns
    -------
    float
        At most 0 (A); 0 until torque and speed are steady.

    Notes
    -----
    After Colby and Novotny, "An efficiency-optimizing permanent-magnet synchronous motor drive", IEEE Transactions on
    Industry Applications 24(3), 1988: in steady operation the output is constant, so least input is least loss. Here
    the search goes on while a speed settles, on the power without what the output has changed by.
    """
    is_other = abs(torque - state.search_torque) > _OTHER_TORQUE * state.greatest_torque
    if is_other or abs(speed - state.search_speed) > _OTHER_SPEED * abs(state.search_speed):
        forget_search(state, torque, speed)
        return 0.0
    state.search_count += 1
    if state.search_count > state.search_settling:
        _look(state, speed, power)
    if state.search_count >= state.search_settling + state.search_looking:
        _move(state, torque)
        _look_anew(state, speed)
    return float(state.search_offset)
