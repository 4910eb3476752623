"""An initial advance angle, to take the place of the reference's line."""

from math import pi

from drivegate import Nameplate


def initial_angle(speed: float, nameplate: Nameplate) -> float:
    """The line that the drive recommends; speeds in rad/s, the angle in rad."""
    line = nameplate.advance_start + nameplate.advance_slope * (speed - nameplate.base_speed)
    return min(max(line, 0.0), pi / 2)
