"""State of the designs, controllers whose search differs from the reference: one record in the caller's buffer."""

from __future__ import annotations

from math import radians
from typing import Final

import numpy as np

from drivegate_models.controllers.current.state import CONTROLLER_STATE

GOLDEN_SECTION: Final = 0
"""Narrows a bracket by the golden ratio."""
QUADRATIC_INTERPOLATION: Final = 1
"""Moves to the vertex of a parabola through three probes."""
ANGLE_TABLE: Final = 2
"""Looks up the angle in a table over speed and current sum."""
SWEEP: Final = 3
"""Sweeps the angle twice, coarse and fine, and returns to where the current sum was least."""

LOWEST_ANGLE: Final = radians(8.0)
"""Minimum angle of a search (rad electrical)."""

TABLE_ROWS: Final = 33
"""Speeds of the table of angles."""
TABLE_COLUMNS: Final = 11
"""Loads of the table of angles."""

DESIGN_STATE: Final = np.dtype(
    [
        # Regulator, angle model and protections, the same as in the built-in controllers.
        ("controller", CONTROLLER_STATE),
        ("design", np.int64),
        # The drive's table: speed of its first row, speed step between rows, current sums and their angles.
        ("table_from", np.float64),
        ("table_step", np.float64),
        ("table_sums", np.float64, (TABLE_ROWS, TABLE_COLUMNS)),
        ("table_angles", np.float64, (TABLE_ROWS, TABLE_COLUMNS)),
        # 1 if the angle for the present load comes from the table.
        ("tabled", np.int64),
        # The present probe: its offset, and the number of decisions since that was reached.
        ("target", np.float64),
        ("waited", np.int64),
        # Findings under the present load: the start of the search, and the cheapest probe.
        ("speed", np.float64),
        ("line", np.float64),
        ("home", np.float64),
        ("home_power", np.float64),
        ("best_offset", np.float64),
        ("best_power", np.float64),
        ("decisions", np.int64),
        # The search itself; each design uses what it needs.
        ("finished", np.int64),
        ("confirming", np.int64),
        ("stride", np.float64),
        # Monitoring at rest.
        ("watched", np.int64),
        ("still", np.int64),
        ("restless", np.int64),
        ("rest_integral", np.float64),
        ("least", np.float64),
        ("most", np.float64),
        ("finest", np.float64),
        ("swing_from", np.float64),
        ("swing_rises", np.int64),
        ("swings", np.int64),
        # 1 if the current sum has fallen with every step since the last probe was measured.
        ("falls", np.int64),
        ("stage", np.int64),
        ("probes", np.int64),
        ("low", np.float64),
        ("high", np.float64),
        ("left", np.float64),
        ("right", np.float64),
        ("low_power", np.float64),
        ("left_power", np.float64),
        ("right_power", np.float64),
        ("high_power", np.float64),
    ],
    align=True,
)
"""Units as in `CONTROLLER_STATE`; all angles but `line` are offsets from the initial angle."""
