"""Records of the intervals between two events, from which waveforms are evaluated exactly later.

A segment is a row of numbers. Within it the current is that of `drivegate_models.machine.winding_current` and the
back-EMF shape is ``SHAPE + SHAPE_RATE * (t - START)``.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

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
"""Rate of the terminal voltage (V/s); zero unless the phase floats or the ideal regulator slides."""
RATE: Final = 9
"""R/L while a current flows freely, 0 while the regulator maintains it (1/s)."""
FIELDS: Final = 10
"""Length of a row."""


@inlined
def store_segment(
    rows: NDArray[np.float64],
    phase: int,
    index: int,
    start: float,
    length: float,
    current: float,
    slope: float,
    curvature: float,
    shape: float,
    shape_rate: float,
    voltage: float,
    voltage_rate: float,
    rate: float,
) -> int:
    """Store a segment if there is space for it.

    `rows`, shape (m, n, FIELDS): receives the segment. `index`: number of segments stored for that phase. The arguments
    after it are the fields, in the units of their indices above. Result: the number of segments stored after this call.
    """
    if index >= rows.shape[1]:
        return index
    rows[phase, index, START] = start
    rows[phase, index, LENGTH] = length
    rows[phase, index, CURRENT] = current
    rows[phase, index, SLOPE] = slope
    rows[phase, index, CURVATURE] = curvature
    rows[phase, index, SHAPE] = shape
    rows[phase, index, SHAPE_RATE] = shape_rate
    rows[phase, index, VOLTAGE] = voltage
    rows[phase, index, VOLTAGE_RATE] = voltage_rate
    rows[phase, index, RATE] = rate
    return index + 1
