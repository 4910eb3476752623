"""Work space for each phase between two events: one record per phase, overwritten in every advance."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

HELD: Final = -1
"""Instead of a tread: the current remains at its level, and the leg's voltage follows the neutral."""

PLACE: Final = np.dtype(
    [
        # Piece of the back-EMF shape, as in `machine.cycle.Shape`.
        ("corner", np.int64),
        ("turn", np.float64),
        ("shape_begin", np.float64),
        ("shape_end", np.float64),
        ("shape_start", np.float64),
        ("shape_rate", np.float64),
        # Piece of the conduction windows, and its end (s).
        ("piece", np.int64),
        ("piece_end", np.float64),
        # Comparator: 1 on, 0 off.
        ("latch", np.int64),
        # The leg's staircase, as in `staircase.Staircase`, and the treads next to the current.
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
        # Interval of the neutral's voltage in which the phase's current is constant (V).
        ("low", np.float64),
        ("high", np.float64),
        # Interval's end that the neutral has reached by the last event: upper (1), lower (-1) or none (0).
        ("reached", np.int64),
        # True if the neutral is at the interval's upper or lower end.
        ("at_high", np.bool_),
        ("at_low", np.bool_),
        # Tread, or HELD; and True if the current leaves its level with a slope of zero.
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
"""State of a phase between two events."""


def make_places(count: int) -> NDArray[Any]:
    """Return work space for a number of phases, shape (count,) of PLACE."""
    return np.zeros(count, PLACE).view(np.recarray)
