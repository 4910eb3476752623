"""Status and tolerance of periodic states, for every kind of drive."""

from __future__ import annotations

from typing import Final

PERIODIC: Final = 1
"""Status of a certified state, which repeats. Used as a number of torque periods, it repeats after one."""
APERIODIC: Final = 0
"""Status without a periodic state."""
TOLERANCE: Final = 1e-10
"""Maximum change of a current over a period that is certified as periodic, relative to 1 A plus the reference (1)."""
