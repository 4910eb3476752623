"""Minimum loss by search: the d-axis current moves in the direction that reduces the power from the link."""

from __future__ import annotations

from math import ceil, isnan, nan, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined

SETTLING: Final = 0.03
"""Time for a new current to settle before the power is averaged (s)."""
LOOKING: Final = 0.02
"""Minimum averaging time (s). It is extended to whole sixths of an electrical cycle, because the power ripples."""
# Maximum averaging time (s). Nothing is tried at speeds whose sixths of a cycle last longer.
_LONGEST = 0.06

# First, largest and smallest step, as shares of the current limit. The first one is taken wherever the torque has
# changed, and adds no more than counts as little. A smaller one would change the power by less than the torque does as
# the speed settles, so that the search would stay wherever the first decisions have left it.
_FIRST_STEP = 0.03
_LARGEST_STEP = 0.06
_SMALLEST_STEP = 0.006
# Minimum relative fall of the power for a step that adds current. The unmeasured torque changes by as much in a step,
# and a search that mistook this for loss would drift.
_LEAST_GAIN = 1e-5
# Consecutive successful steps after which steps grow. They are fewer while a search narrows down.
_FAR = 3
# Change of torque relative to the maximum, and relative change of speed, beyond which the operating point is another.
_OTHER_TORQUE = 0.02
_OTHER_SPEED = 0.02
# Torque relative to the maximum below which nothing is tried: drops and dead time move the torque by more power than
# the losses change.
_LEAST_TORQUE = 0.05


@inlined
def reset_search(state: Any, nameplate: Any) -> None:
    """Write the constants of the search and reset everything else."""
    period = nameplate.control_period
    state.search_settling = int(SETTLING / period)
    state.search_shortest = LOOKING / period
    state.search_sixth = pi / 3.0 / (nameplate.pole_pairs * period)
    state.search_slowest = state.search_sixth / (_LONGEST / period)
    state.search_inertia = nameplate.inertia / period
    restart_search(state, 0.0, 0.0)


@inlined
def restart_search(state: Any, torque: float, speed: float) -> None:
    """Restart the search at a torque (N m) and a speed (rad/s)."""
    state.search_torque = torque
    state.search_speed = speed
    state.search_offset = 0.0
    state.search_step = -_FIRST_STEP * state.full_current
    state.search_gains = 0
    state.search_power = nan
    _begin_averaging(state, speed)


@inlined
def _begin_averaging(state: Any, speed: float) -> None:
    """Start the settling time of a new current, and choose the averaging time for the speed (rad/s)."""
    # Nothing is tried at lower speeds, but the search restarts there too.
    sixth = state.search_sixth / max(abs(speed), state.search_slowest)
    averaging = ceil(state.search_shortest / sixth) * sixth
    state.search_looking = 2 * int(0.5 * averaging + 0.5)
    state.search_count = 0
    state.search_sum = 0.0
    state.search_early = 0.0
    state.search_late = 0.0


@inlined
def _accumulate(state: Any, speed: float, power: float) -> None:
    """Accumulate the power (W) and the speed (rad/s) of a period."""
    state.search_sum += power
    if 2 * (state.search_count - state.search_settling) > state.search_looking:
        state.search_late += speed
    else:
        state.search_early += speed


@inlined
def _step_search(state: Any, torque: float) -> None:
    """Take the next step: continue while the power falls, grow while it keeps falling, otherwise reverse and halve.

    While a speed settles, the power into inertia and load changes by more than the loss. It is subtracted, because
    the search would otherwise follow the speed's fluctuations. If the power rises with a step and also with the next
    one, back, the load changes it too. The search then reverts both steps, and averages again before it compares.
    """
    mean_speed = (state.search_early + state.search_late) / state.search_looking
    # The means of the two halves of the averaging time are half of it apart.
    half = 0.5 * state.search_looking
    accelerating = (
        state.search_inertia * mean_speed * (state.search_late - state.search_early) / (half * half)
    )
    power = state.search_sum / state.search_looking - accelerating
    is_first = isnan(state.search_power)
    least_gain = _LEAST_GAIN * abs(power) if state.search_step < 0.0 else 0.0
    falls = power - torque * (mean_speed - state.search_pace) < state.search_power - least_gain
    goes_back = not is_first and not falls and state.search_gains < 0
    if is_first:
        factor = 1.0
    elif falls:
        state.search_gains = max(state.search_gains, 0) + 1
        factor = 2.0 if state.search_gains >= _FAR else 1.0
    elif goes_back:
        state.search_gains = 0
        factor = 0.5
    else:
        state.search_gains = -1
        factor = -0.5
    if falls or is_first:
        state.search_good_offset = state.search_offset
    _choose_step(state, factor)
    if goes_back:
        state.search_offset = state.search_good_offset
        state.search_power = nan
    else:
        state.search_offset += state.search_step
        state.search_power = power
        state.search_pace = mean_speed


@inlined
def _choose_step(state: Any, factor: float) -> None:
    """Choose a step by a factor on the last one, without a current that strengthens the field: it turns back at 0."""
    step = factor * state.search_step
    if step > 0.0 and state.search_offset == 0.0:
        step = -0.5 * state.search_step
        state.search_gains = 0
    size = min(max(abs(step), _SMALLEST_STEP * state.full_current), _LARGEST_STEP * state.full_current)
    state.search_step = min(size if step > 0.0 else -size, -state.search_offset)


@inlined
def searched_offset(state: Any, torque: float, speed: float, power: float) -> float:
    """Return the offset of the d-axis current (A, at most 0) in one period of the search for minimum power.

    `torque` is the requested torque (N m), `speed` the shaft's (rad/s) and `power` the one from the link in the
    period just ended (W). The offset is 0 until torque and speed are steady.

    The method is that of Colby and Novotny, "An efficiency-optimizing permanent-magnet synchronous motor drive",
    IEEE Transactions on Industry Applications 24(3), 1988: in steady operation the output is constant, so minimum
    input is minimum loss. Here the search continues while a speed settles, on the power minus the change of the
    output.
    """
    is_little = abs(torque) < _LEAST_TORQUE * state.greatest_torque
    is_slow = abs(speed) <= state.search_slowest
    has_other_torque = abs(torque - state.search_torque) > _OTHER_TORQUE * state.greatest_torque
    has_other_speed = abs(speed - state.search_speed) > _OTHER_SPEED * abs(state.search_speed)
    if is_little or is_slow or has_other_torque or has_other_speed:
        restart_search(state, torque, speed)
        return 0.0
    state.search_count += 1
    if state.search_count > state.search_settling:
        _accumulate(state, speed, power)
    if state.search_count >= state.search_settling + state.search_looking:
        _step_search(state, torque)
        _begin_averaging(state, speed)
    return float(state.search_offset)
