"""The model of the initial advance angle (paper, Fig. 3)."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def initial_angle(speed: float, base_speed: float, angle_at_base: float, slope: float) -> float:
    """Return the initial advance angle (rad electrical), limited to 0 to 90 degrees.

    Below `base_speed` (rad/s) it is zero. Above, it starts at `angle_at_base` (rad electrical; 0 in the paper's Fig. 3)
    and rises by `slope` (rad electrical per rad/s).
    """
    if speed < base_speed:
        return 0.0
    return min(max(angle_at_base + slope * (speed - base_speed), 0.0), 1.5707963267948966)
