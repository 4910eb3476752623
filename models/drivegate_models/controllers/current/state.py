"""State of the built-in controllers, one record in the buffer that the caller provides."""

from __future__ import annotations

from math import radians
from typing import Final

import numpy as np

NO_SEARCH: Final = 0
"""The initial angle alone (Fig. 3), the yardstick of Fig. 7."""
FLOWCHART: Final = 1
"""The search of Fig. 4, literally."""
GUARDED: Final = 2
"""The search with the additions that its counterexamples made necessary."""

SETTLING: Final = 0
"""Mode: command or load has changed; wait until the current sum repeats."""
SEARCHING: Final = 1
"""Mode: each decision moves the angle."""
HOLDING: Final = 2
"""Mode: the optimum is found; wait for a change."""
STEPPED_OFF: Final = -1
"""Count of quiet intervals while holding, right after a step off the edge."""
NOT_RETRIED: Final = 0
"""No forbidden angle has been tried again under the present load."""
RETRIED: Final = 1
"""Angles that may have been forbidden without cause have been allowed again."""
RETRIED_WITH_CARE: Final = 2
"""So have more of them, since to keep off them costs much; only small steps lead among them."""
SMALLEST_STEP: Final = radians(0.24)
"""Least step of a search (rad electrical)."""

CONTROLLER_STATE: Final = np.dtype(
    [
        ("search", np.int64),
        # Constants, set by reset.
        ("angle_at_base", np.float64),
        ("angle_slope", np.float64),
        ("advance_begins", np.float64),
        ("base_speed", np.float64),
        ("nominal_voltage", np.float64),
        ("current_limit", np.float64),
        # Current sum that the supply gives at rated power.
        ("rated_sum", np.float64),
        ("control_period", np.float64),
        # The same in the drive's own time, which runs with its electrical frequency at base speed.
        ("paced_period", np.float64),
        ("window", np.float64),
        ("conducting_phases", np.float64),
        ("proportional", np.float64),
        ("integral_step", np.float64),
        ("speed_tolerance", np.float64),
        ("power_tolerance", np.float64),
        ("least_change", np.float64),
        # Whether small steps try forbidden angles again: then more angle is given back where the speed falls on, and
        # under load a whole step alone is no proof that its angle loses the torque.
        ("tries_again", np.int64),
        ("first_step", np.float64),
        ("decision_steps", np.int64),
        # Regulator and angle model.
        ("integral", np.float64),
        ("advancing", np.int64),
        # Search: the offset from the initial angle and how it moves.
        ("offset", np.float64),
        ("step", np.float64),
        ("direction", np.float64),
        ("old_power", np.float64),
        # The running decision interval.
        ("count", np.int64),
        ("power_sum", np.float64),
        ("worst_error", np.float64),
        # Speed reference minus speed in its last step.
        ("error", np.float64),
        ("saturated", np.int64),
        # The guarded search only.
        ("mode", np.int64),
        ("quiet", np.int64),
        ("quiet_from", np.float64),
        ("forbidden", np.float64),
        ("held_power", np.float64),
        ("rest_power", np.float64),
        ("speed_reference", np.float64),
        ("supply_voltage", np.float64),
        ("saturated_run", np.int64),
        ("speed_mark", np.float64),
        ("moved", np.float64),
        ("improvements", np.int64),
        # Under the present load.
        ("reversals", np.int64),
        ("good_integral", np.float64),
        ("good_offset", np.float64),
        ("good_power", np.float64),
        ("forbidden_power", np.float64),
        ("lost_at", np.float64),
        ("retried", np.int64),
        ("calm_error", np.float64),
        ("last_power", np.float64),
        ("last_integral", np.float64),
        ("winding", np.int64),
        ("starved_run", np.int64),
        ("starved_mark", np.float64),
        # Speed that was lost when a step was last given back; infinite while none is lost.
        ("lost_speed", np.float64),
        ("climb", np.float64),
        ("regained", np.float64),
        ("worse", np.int64),
        ("worse_from", np.float64),
        ("confirmed", np.int64),
        ("jolted_at", np.float64),
        ("waited", np.int64),
        ("widened", np.int64),
        ("initial_power", np.float64),
    ],
    align=True,
)
"""Angles in rad electrical, speeds in rad/s, currents (and the search's power, as a current sum) in A."""
