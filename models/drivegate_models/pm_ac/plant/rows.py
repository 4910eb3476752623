"""What is known of the segments of a whole control period, in one array: row after row of `WIDTH` entries.

Every row is computed from rows that lie behind it. So the compiler knows that no entry that is written is read for a
later one, and lets the processor work on several segments at once.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

WIDTH: Final = 16
"""Entries of a row."""
GROUP: Final = 4
"""Entries that are worked on at once, at most."""
MOST: Final = WIDTH - GROUP
"""Segments that there is room for, with the instant behind the last one."""

SQUARE: Final = 0 * WIDTH
"""Integral of the squares of the currents of the rotor frame over each segment (A2 s)."""
TORQUE: Final = 1 * WIDTH
"""Integral of the torque over three halves of the pole pairs (V A s2)."""
CHARGE_ALONG: Final = 2 * WIDTH
"""Integral of the current along the first phase's axis (A s)."""
CHARGE_ACROSS: Final = 3 * WIDTH
"""And across it (A s)."""
PHASE: Final = 4 * WIDTH
"""Current of the first phase at the start of each segment, and behind the last one (A); those of the others follow."""
DIRECT: Final = 7 * WIDTH
"""Current along the magnet's axis at the start of each segment, and behind the last one (A)."""
QUADRATURE: Final = 8 * WIDTH
"""And across it (A)."""
COSINE: Final = 9 * WIDTH
"""Cosine of the electrical angle then (1)."""
SINE: Final = 10 * WIDTH
"""Its sine (1)."""
DIRECT_GROWTH: Final = 11 * WIDTH
"""What the current along the magnet's axis gains by itself in each segment (1)."""
DIRECT_BY_QUADRATURE: Final = 12 * WIDTH
"""What it gains by that across (1)."""
DIRECT_ADDED: Final = 13 * WIDTH
"""What it gains without any current (A)."""
QUADRATURE_GROWTH: Final = 14 * WIDTH
"""What the current across the magnet's axis gains by itself in each segment (1)."""
QUADRATURE_BY_DIRECT: Final = 15 * WIDTH
"""What it gains by that along (1)."""
QUADRATURE_ADDED: Final = 16 * WIDTH
"""What it gains without any current (A)."""
TIME: Final = 17 * WIDTH
"""Start of each segment, from the period's start, and end of the last one (s)."""
ALONG: Final = 18 * WIDTH
"""Voltage along the first phase's axis (V)."""
ACROSS: Final = 19 * WIDTH
"""And across it (V)."""
LINK_ALONG: Final = 20 * WIDTH
"""The link's current over that along the first phase's axis (1)."""
LINK_ACROSS: Final = 21 * WIDTH
"""And over that across it (1)."""
DROP: Final = 22 * WIDTH
"""Forward drop in the first leg (V), if there are any; the rows of the second and third one follow."""
_ROWS = 25


def make_rows() -> NDArray[np.float64]:
    """Return room for all rows."""
    return np.zeros(_ROWS * WIDTH)


@inlined
def whole_groups(count: int) -> int:
    """Return how many entries are worked on for so many."""
    # Bounded, so that the compiler knows that no index overflows.
    return int(min(GROUP * ((count + GROUP - 1) // GROUP), WIDTH - GROUP))
