"""State of the designs, controllers that search otherwise than the reference: one record in the caller's buffer."""

from __future__ import annotations

from math import radians
from typing import Final

import numpy as np

GOLDEN_SECTION: Final = 0
"""Narrows a bracket by the golden ratio."""
QUADRATIC_INTERPOLATION: Final = 1
"""Goes to the vertex of a parabola through three probes."""
ANGLE_TABLE: Final = 2
"""Takes the angle from a table over speed and current sum."""
SWEEP: Final = 3
"""Sweeps the angle twice, coarse and fine, and returns to where the current sum was least."""
SLOPE_BISECTION: Final = 4
"""Halves a bracket by the sign of the slope."""

SETTLING: Final = 0
"""Mode: at the starting angle, until the current sum repeats."""
MOVING: Final = 1
"""Mode: the angle slews to the next probe."""
PAUSING: Final = 2
"""Mode: the probe's angle is reached; the regulator settles."""
MEASURING: Final = 3
"""Mode: the probe's current sum is averaged."""
RECOVERING: Final = 4
"""Mode: the last move lost the torque and is taken back."""
RESTING: Final = 5
"""Mode: the optimum is found; it is watched."""
RECHECKING: Final = 6
"""Mode: rest was disturbed; back at the starting angle, to tell a changed load from a lost torque."""

MARGIN: Final = radians(0.3)
"""Distance from an angle that has lost the torque, within which nothing is probed (rad electrical)."""
LOWEST_ANGLE: Final = radians(1.0)
"""Least angle that a search looks at (rad electrical)."""

DESIGN_STATE: Final = np.dtype(
    [
        ("design", np.int64),
        # Constants, set by reset.
        ("base_speed", np.float64),
        ("advance_begins", np.float64),
        ("nominal_voltage", np.float64),
        ("current_limit", np.float64),
        ("control_period", np.float64),
        ("proportional", np.float64),
        ("integral_step", np.float64),
        ("starving_dwell", np.float64),
        ("slowest_regain", np.float64),
        # Sensors, as far as they are believed.
        ("speed", np.float64),
        ("voltage", np.float64),
        ("current_sum", np.float64),
        ("speed_doubted", np.int64),
        ("voltage_doubted", np.int64),
        ("current_doubted", np.int64),
        ("blind", np.int64),
        # Regulator and angle model.
        ("integral", np.float64),
        ("advancing", np.int64),
        ("line", np.float64),
        # Regulation guard.
        ("speed_reference", np.float64),
        ("supply", np.float64),
        ("error", np.float64),
        ("alarm_run", np.int64),
        ("relief_run", np.int64),
        ("saturated_run", np.int64),
        ("speed_mark", np.float64),
        ("good_offset", np.float64),
        ("good_integral", np.float64),
        ("forbidden", np.float64),
        # The running interval.
        ("count", np.int64),
        ("power_sum", np.float64),
        ("first_half", np.float64),
        ("worst_error", np.float64),
        ("integral_sum", np.float64),
        ("saturated", np.int64),
        # The angle's movement, as an offset from the initial angle.
        ("mode", np.int64),
        ("elapsed", np.int64),
        ("age", np.int64),
        ("offset", np.float64),
        ("target", np.float64),
        ("rate", np.float64),
        ("old_power", np.float64),
        ("repeats", np.int64),
        # What is known of the present load.
        ("home", np.float64),
        ("home_power", np.float64),
        ("home_ratio", np.float64),
        ("home_error", np.float64),
        ("grain", np.float64),
        ("proven", np.float64),
        ("best_offset", np.float64),
        ("best_power", np.float64),
        ("held_power", np.float64),
        ("first_held_power", np.float64),
        ("held_integral", np.float64),
        ("lowest_power", np.float64),
        ("highest_power", np.float64),
        ("escapes", np.int64),
        ("intervals", np.int64),
        ("restarts", np.int64),
        ("disturbances", np.int64),
        ("pursuing", np.int64),
        ("doubtful", np.int64),
        ("disturbed_at", np.float64),
        # The search itself; each design uses what it needs.
        ("finished", np.int64),
        ("stage", np.int64),
        ("probes", np.int64),
        ("low", np.float64),
        ("high", np.float64),
        ("left", np.float64),
        ("right", np.float64),
        ("low_power", np.float64),
        ("high_power", np.float64),
        ("left_power", np.float64),
        ("right_power", np.float64),
    ],
    align=True,
)
"""Angles in rad electrical, speeds in rad/s, currents (and the search's power, as a current sum) in A."""
