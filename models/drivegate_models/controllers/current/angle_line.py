"""The model of the initial advance angle (paper, Fig. 3)."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def initial_angle(speed: float, base_speed: float, angle_at_base: float, slope: float) -> float:
    """Return the initial advance angle: zero below base speed, a straight line in speed above.

    Parameters
    ----------
    speed : float
        Shaft speed (rad/s).
    base_speed : float
        Speed at which the line begins (rad/s).
    angle_at_base : float
        The line's angle at base speed (rad electrical); 0 in the paper's Fig. 3.
    slope : float
        Its slope (rad electrical a rad/s).

    Returns
    -------
    float
        Angle (rad electrical), 0 to 90 degrees.
    """
    if speed < base_speed:
        return 0.0
    return min(max(angle_at_base + slope * (speed - base_speed), 0.0), 1.5707963267948966)
