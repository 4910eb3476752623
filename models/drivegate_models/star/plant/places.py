"""What the plant knows of each phase between two events: one record a phase, room that every advance writes anew."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

HELD: Final = -1
"""Instead of a tread: the current stays at its level, and the leg's voltage follows the neutral."""

PLACE: Final = np.dtype(
    [
        # Piece of the back-EMF shape, as in `machine.cycle.Shape`.
        ("corner", np.int64),
        ("turn", np.float64),
        ("shape_begin", np.float64),
        ("shape_end", np.float64),
        ("shape_start", np.float64),
        ("shape_rate", np.float64),
        # Piece of the conduction windows, and when it ends (s).
        ("piece", np.int64),
        ("piece_end", np.float64),
        # Comparator: 1 on, 0 off.
        ("latch", np.int64),
        # The leg's staircase, as in `staircase.Staircase`, and the treads beside the current.
        ("first", np.float64),
        ("second", np.float64),
        ("gate", np.int64),
        ("below", np.int64),
        ("above", np.int64),
        # Current (A) and shape of the back-EMF (1) at the start of a stretch, e + R i (V) and the rate of e (V/s).
        ("start", np.float64),
        ("emf_shape", np.float64),
        ("opposed", np.float64),
        ("opposed_rate", np.float64),
        # Interval in which the phase is content with the neutral (V).
        ("low", np.float64),
        ("high", np.float64),
        # An event has just taken the neutral to the interval's upper end (1) or lower end (-1).
        ("reached", np.int64),
        # The neutral lies at the interval's upper or lower end.
        ("at_high", np.bool_),
        ("at_low", np.bool_),
        # Tread, or HELD; and whether the current leaves its level with a slope of zero.
        ("tread", np.int64),
        ("is_leaving", np.bool_),
        # Motion of the current: slope (A/s), curvature (A/s2), and the levels that end it (A).
        ("slope", np.float64),
        ("curvature", np.float64),
        ("floor", np.float64),
        ("ceiling", np.float64),
    ],
    align=True,
)
"""A phase between two events."""


def make_places(count: int) -> NDArray[Any]:
    """Return room for a number of phases."""
    return np.zeros(count, PLACE).view(np.recarray)
