"""The design that sweeps the advance angle, coarse and fine, and returns to where the current sum was least."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.angle_movement import DOWNWARD
from drivegate_models.compilation import unfused
from drivegate_models.design_state import LOWEST_ANGLE
from drivegate_models.regulation_recovery import winds_up

COARSE_RATE: Final = radians(25.0)
"""Rate of the first sweep (rad electrical/s)."""
FINE_RATE: Final = radians(4.0)
"""Rate of the second (rad electrical/s)."""

_SAMPLE = 0.05
_RISEN = 1.05
_OFF_EDGE = radians(0.7)
_AROUND = radians(3.0)


@unfused
def sweep_rate(state: Any) -> float:
    """Return the rate at which the angle goes to the next target.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state.

    Returns
    -------
    float
        (rad electrical/s).
    """
    if state.stage == 0:
        return COARSE_RATE
    return FINE_RATE if state.stage == 2 else DOWNWARD


@unfused
def begin_sweep(state: Any) -> float:
    """Sweep down from the starting angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `left` is the offset of the least sample, `right_power` sums up a sample.

    Returns
    -------
    float
        Where the sweep leads to (rad electrical).
    """
    state.left = state.home
    state.left_power = state.home_power
    state.right_power = 0.0
    state.probes = 0
    lowest: float = LOWEST_ANGLE - state.line
    return lowest


@unfused
def sample_sweep(state: Any) -> None:
    """Watch the current sum during a sweep; end the sweep early where it has risen well above its least.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    if state.stage == 1 or state.blind > 0:
        state.probes = 0
        state.right_power = 0.0
        return
    state.probes += 1
    state.right_power += state.current_sum
    if state.probes * state.control_period < _SAMPLE:
        return
    power = state.right_power / state.probes
    if power < state.left_power and not winds_up(state, state.integral, power):
        state.left_power = power
        state.left = state.offset + 0.5 * state.rate * _SAMPLE
    elif power > _RISEN * state.left_power:
        state.target = state.offset
        state.elapsed = 0
    state.probes = 0
    state.right_power = 0.0


@unfused
def continue_sweep(state: Any) -> float:
    """Go from the coarse sweep to a start beside its least sample, and from there into the fine sweep.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    float
        Where to go (rad electrical).
    """
    state.probes = 0
    state.right_power = 0.0
    state.stage += 1
    if state.stage == 1:
        start: float = min(state.left + _AROUND, state.home)
        return start
    if state.stage == 2 and state.old_power < inf:
        end: float = max(state.left - _AROUND, state.forbidden)
        state.left_power = state.old_power
        state.left = state.offset
        return end
    state.best_offset = max(state.left, state.forbidden + _OFF_EDGE)
    state.best_power = state.left_power
    state.finished = 1
    best: float = state.best_offset
    return best
