"""Data of the segments of a whole control period, in one array: consecutive rows of `WIDTH` entries.

Every row is computed from rows after it. So the compiler knows that no written entry is read for a later one, and can
vectorize over several segments.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

WIDTH: Final = 16
"""Entries of a row."""
GROUP: Final = 4
"""Maximum number of entries that are processed at once."""
MOST: Final = WIDTH - GROUP
"""Maximum number of segments, with space for the instant after the last one."""

SQUARE: Final = 0 * WIDTH
"""Integral of the squared d-q current over each segment (A2 s)."""
TORQUE: Final = 1 * WIDTH
"""Integral of the torque over 1.5 times the pole pairs (V A s2)."""
CHARGE_ALONG: Final = 2 * WIDTH
"""Integral of the current along the first phase's axis (A s)."""
CHARGE_ACROSS: Final = 3 * WIDTH
"""Integral of the current across the first phase's axis (A s)."""
PHASE: Final = 4 * WIDTH
"""Current of the first phase at the start of each segment, and after the last one (A); the other phases follow."""
DIRECT: Final = 7 * WIDTH
"""d-axis current at the start of each segment, and after the last one (A)."""
QUADRATURE: Final = 8 * WIDTH
"""q-axis current at the start of each segment, and after the last one (A)."""
COSINE: Final = 9 * WIDTH
"""Cosine of the electrical angle at these instants (1)."""
SINE: Final = 10 * WIDTH
"""Sine of the electrical angle at these instants (1)."""
DIRECT_GROWTH: Final = 11 * WIDTH
"""Change of the d-axis current in a segment, per initial d-axis current (1)."""
DIRECT_BY_QUADRATURE: Final = 12 * WIDTH
"""Change of the d-axis current in a segment, per initial q-axis current (1)."""
DIRECT_ADDED: Final = 13 * WIDTH
"""Change of the d-axis current in a segment from zero currents (A)."""
QUADRATURE_GROWTH: Final = 14 * WIDTH
"""Change of the q-axis current in a segment, per initial q-axis current (1)."""
QUADRATURE_BY_DIRECT: Final = 15 * WIDTH
"""Change of the q-axis current in a segment, per initial d-axis current (1)."""
QUADRATURE_ADDED: Final = 16 * WIDTH
"""Change of the q-axis current in a segment from zero currents (A)."""
TIME: Final = 17 * WIDTH
"""Start of each segment, from the period's start, and end of the last one (s)."""
ALONG: Final = 18 * WIDTH
"""Voltage along the first phase's axis (V)."""
ACROSS: Final = 19 * WIDTH
"""Voltage across the first phase's axis (V)."""
LINK_ALONG: Final = 20 * WIDTH
"""The link's current per current along the first phase's axis (1)."""
LINK_ACROSS: Final = 21 * WIDTH
"""The link's current per current across the first phase's axis (1)."""
DROP: Final = 22 * WIDTH
"""Forward drop in the first leg (V), if there are drops; the rows of the other two legs follow."""

# Rows of a period of a link with a capacitor, which needs neither derivatives nor maps.
DROPPED: Final = 4 * WIDTH
"""Integral of the source's voltage less the link's over each segment (V s)."""
DROPPED_SQUARE: Final = 5 * WIDTH
"""Integral of the square of that (V2 s)."""
ENERGY: Final = 6 * WIDTH
"""Energy into the bridge (J)."""
PHASE_ENDS: Final = 11 * WIDTH
"""Current of the first phase at the start of each segment, and after the last one (A); the other phases follow."""
DEVIATION: Final = 14 * WIDTH
"""Maximum distance of a phase current from its chord (A)."""
SERIES_ORDERS: Final = 12
"""Coefficients of the series in each segment."""
SERIES_ALONG: Final = 25 * WIDTH
"""Series of the current along the first phase's axis (A): a row for each coefficient."""
SERIES_ACROSS: Final = SERIES_ALONG + SERIES_ORDERS * WIDTH
"""Series of the current across that axis (A)."""
SERIES_VOLTAGE: Final = SERIES_ACROSS + SERIES_ORDERS * WIDTH
"""Series of the link's voltage (V)."""
_ROWS = 25 + 3 * SERIES_ORDERS


def make_rows() -> NDArray[np.float64]:
    return np.zeros(_ROWS * WIDTH)


@inlined
def whole_groups(count: int) -> int:
    """Return the number of processed entries for a number of segments: whole groups."""
    # The bound shows the compiler that no index overflows.
    return int(min(GROUP * ((count + GROUP - 1) // GROUP), WIDTH - GROUP))
