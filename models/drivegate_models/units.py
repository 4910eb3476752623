"""Factors between the units of people and SI."""

from math import pi
from typing import Final

RADIANS_PER_RPM: Final = pi / 30.0
"""Speed of one turn a minute (rad/s)."""
RPM: Final = 30.0 / pi
"""Speed of one radian a second (1/min)."""
DEGREES: Final = 180.0 / pi
"""Angle of one radian (deg)."""
