"""Faults in what a controller makes of the shaft's angle and speed."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn

# Share of the present speed that its mean adopts in each step (1).
_ADOPTED: Final = 1.0 / 512.0


@inlined
def follow_shaft(state: Any, sense: Any) -> None:
    """Update the mean speed, and what the controller adds to the angle after jumps."""
    if state.is_following == 0:
        state.is_following = 1
        state.mean_speed = sense.speed
        state.turned_before = sense.speed * state.control_period
        state.angle_seen = sense.angle - state.turned_before
        if state.assumes_zero == 1 and sense.speed == 0.0:
            state.angle_added -= sense.angle
    # Hall switches show a speed that jumps at their edges.
    adopted = _ADOPTED if sense.hall < 0 else 1.0
    state.mean_speed += adopted * (sense.speed - state.mean_speed)
    turned = within_half_turn(sense.angle - state.angle_seen)
    state.angle_seen = sense.angle
    jump = turned - state.turned_before
    if sense.hall < 0 and abs(jump) > state.farthest_jump > 0.0:
        if state.trips_at_jump == 1:
            state.is_off = 1
        state.angle_added += state.jump_taken_for
        if state.angle_slew > 0.0:
            state.angle_added -= jump
    else:
        state.turned_before = turned
    if state.angle_slew > 0.0:
        state.angle_added -= min(max(state.angle_added, -state.angle_slew), state.angle_slew)
