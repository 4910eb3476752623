"""An initial advance angle, to take the place of the reference's line."""

from math import pi, radians

from drivegate import Nameplate


def initial_angle(speed: float, nameplate: Nameplate) -> float:
    """33° at base speed and 0.025° more for each rpm above it; speeds in rad/s, the angle in rad."""
    slope = radians(0.025) * 30.0 / pi
    return min(max(radians(33.0) + slope * (speed - nameplate.base_speed), 0.0), pi / 2)
