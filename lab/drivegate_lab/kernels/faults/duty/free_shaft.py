"""Faults of a shaft that begins to turn freely, or that has turned for hours."""

from __future__ import annotations

from math import floor
from typing import Any, Final

import numpy as np

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn

# Rate at which the regulator unwinds once the shaft turns (1/s).
_UNWINDING: Final = 5.0
FREE_SHAFT: Final = (
    # 1 if the speed at the last change of the reference is taken for the present one; that reference and speed (rad/s).
    ("keeps_speed", np.int64),
    ("reference_kept", np.float64),
    ("speed_kept", np.float64),
    # Speed below which the shaft counts as standing (rad/s), 0 for never; control periods after which a standing shaft
    # counts as stalled, and of the ramp of the torque once it turns again; those that it has stood, and has turned.
    ("standing", np.float64),
    ("stalled_after", np.int64),
    ("ramped_within", np.int64),
    ("stood", np.int64),
    ("moved", np.int64),
    # Rate at which a regulator winds up while the shaft stands (1/s), and what it has added to the reference (rad/s).
    ("windup_rate", np.float64),
    ("wound_up", np.float64),
    # Steps of the angle that are summed in single precision since the start (rad), 0 for none; the sum in these steps,
    # and the step of the preceding period.
    ("summed_step", np.float64),
    ("summed", np.float32),
    ("step_before", np.float64),
)
"""Fields of the state."""


@inlined
def _speed_of_the_last_change(state: Any, sense: Any) -> float:
    """Return the speed at the last change of the reference (rad/s)."""
    if state.speed_kept == 0.0 or sense.reference != state.reference_kept:
        state.speed_kept = sense.speed
    state.reference_kept = sense.reference
    return float(state.speed_kept)


@inlined
def _summed_angle(state: Any, angle: float) -> float:
    """Return the angle that a sum of all steps since the start has in single precision (rad)."""
    step = floor(angle / state.summed_step)
    passed = within_half_turn((step - state.step_before) * state.summed_step) / state.summed_step
    state.step_before = step
    state.summed = np.float32(state.summed + np.float32(floor(passed + 0.5)))
    return float(state.summed * state.summed_step)


@inlined
def _ramp_after_a_stall(state: Any, sense: Any) -> float:
    """Return the share of the reference after a stall (1)."""
    if abs(sense.speed) < state.standing and sense.reference != 0.0:
        state.stood += 1
        state.moved = 0
    elif state.stood >= state.stalled_after:
        state.moved += 1
        if state.moved >= state.ramped_within:
            state.stood = 0
        return float(state.moved / state.ramped_within)
    else:
        state.stood = 0
    return 1.0


@inlined
def _added_by_windup(state: Any, sense: Any) -> float:
    """Return what a regulator without a limit adds to the reference after a stall (rad/s)."""
    if abs(sense.speed) < state.standing:
        state.wound_up += state.windup_rate * state.control_period * sense.reference
    else:
        state.wound_up -= _UNWINDING * state.control_period * state.wound_up
    return float(state.wound_up)


@inlined
def perturb_free_shaft(state: Any, sense: Any, perturbed: Any) -> None:
    """Perturb the Sense of a controller that takes a free shaft for one that is held, or counts all its turns."""
    if state.keeps_speed == 1:
        perturbed.speed = _speed_of_the_last_change(state, sense)
    if state.ramped_within > 0:
        perturbed.reference *= _ramp_after_a_stall(state, sense)
    if state.windup_rate > 0.0:
        perturbed.reference += _added_by_windup(state, sense)
    if state.summed_step > 0.0:
        perturbed.angle = _summed_angle(state, sense.angle)
