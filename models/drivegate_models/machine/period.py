"""What every kind of drive says of its periodic states."""

from __future__ import annotations

from typing import Final

PERIODIC: Final = 1
"""Certified: the state repeats, as a number of torque periods after one of them."""
APERIODIC: Final = 0
"""No periodic state was found."""
TOLERANCE: Final = 1e-10
"""Greatest change of a current over a period that is certified as periodic, over 1 A and the reference together (1)."""
