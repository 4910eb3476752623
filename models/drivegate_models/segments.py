"""What is kept of each interval between two events, so that waveforms can be evaluated exactly later.

A segment is a row of numbers. Within it the current is that of `drivegate_models.winding_current` and the
back-EMF shape is ``SHAPE + SHAPE_RATE * (t - START)``.
"""

from typing import Final

START: Final = 0
"""Start (s), from the beginning of the advance."""
LENGTH: Final = 1
"""Length (s)."""
CURRENT: Final = 2
"""Current at the start (A)."""
SLOPE: Final = 3
"""Slope of the current at the start (A/s)."""
CURVATURE: Final = 4
"""Slope of the back-EMF over the inductance (A/s2)."""
SHAPE: Final = 5
"""Back-EMF shape at the start (1)."""
SHAPE_RATE: Final = 6
"""Rate of the back-EMF shape (1/s)."""
VOLTAGE: Final = 7
"""Terminal voltage at the start (V)."""
VOLTAGE_RATE: Final = 8
"""Rate of the terminal voltage (V/s); not zero only while the phase floats or the ideal regulator slides."""
RATE: Final = 9
"""R/L while a current flows freely, 0 while it is held (1/s)."""
FIELDS: Final = 10
"""Length of a row."""
