"""Factors between customary units and SI."""

from math import pi
from typing import Final

RADIANS_PER_RPM: Final = pi / 30.0
"""Speed of one revolution per minute (rad/s)."""
RPM: Final = 30.0 / pi
"""Speed of one radian per second (rpm)."""
DEGREES: Final = 180.0 / pi
"""Angle of one radian (deg)."""
