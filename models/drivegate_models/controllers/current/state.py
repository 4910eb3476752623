"""State of the built-in controllers, one record in the buffer that the caller provides."""

from __future__ import annotations

from math import radians
from typing import Final

import numpy as np

NO_SEARCH: Final = 0
"""The initial angle alone (Fig. 3), the yardstick of Fig. 7."""
FLOWCHART: Final = 1
"""The search of Fig. 4, unchanged."""
GUARDED: Final = 2
"""The search with the additions that counterexamples to the published one require."""

SETTLING: Final = 0
"""Mode: command or load has changed; wait until the current sum repeats."""
SEARCHING: Final = 1
"""Mode: each decision moves the angle."""
HOLDING: Final = 2
"""Mode: the optimum is found; wait for a change."""
FOLLOWING: Final = 3
"""Mode: the current is not limited, and the angle regulates the speed."""
STEPPED_OFF: Final = -1
"""Value of `quiet` while holding, directly after a step off the edge."""
NOT_RETRIED: Final = 0
"""Under the present load, no forbidden angle has been allowed again."""
RETRIED: Final = 1
"""Angles that were possibly forbidden without cause are allowed again."""
RETRIED_WITH_CARE: Final = 2
"""More of these angles are allowed again, because avoiding them is costly; only small steps enter them."""
NOT_PROBED: Final = 0
"""Angles beyond the one at which the search would rest have not been tried."""
PROBING: Final = 1
"""The last step was a probe: one long step from where the search would rest."""
PROBED: Final = 2
"""The probe has found nothing."""
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
        # Current sum at rated power and nominal supply voltage.
        ("rated_sum", np.float64),
        ("control_period", np.float64),
        # The control period, scaled by the drive's electrical frequency at base speed.
        ("paced_period", np.float64),
        ("window", np.float64),
        ("conducting_phases", np.float64),
        ("proportional", np.float64),
        ("integral_step", np.float64),
        ("speed_tolerance", np.float64),
        ("power_tolerance", np.float64),
        ("least_change", np.float64),
        # 1 if small steps may try forbidden angles again. The search then reverts more angle while the speed keeps
        # falling, and under load a whole step alone does not prove that its angle loses the torque. After a long step
        # that looks like another load, it goes on with short ones.
        ("tries_again", np.int64),
        ("first_step", np.float64),
        ("decision_steps", np.int64),
        # Speed regulator and angle model.
        ("integral", np.float64),
        ("advancing", np.int64),
        # Search: the offset from the initial angle and how it moves.
        ("offset", np.float64),
        # The offset at which the angle is zero.
        ("lowest", np.float64),
        ("step", np.float64),
        ("direction", np.float64),
        ("old_power", np.float64),
        # The present decision interval.
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
        # Decisions in a row at which the search waited for the current sum to repeat.
        ("unsettled", np.int64),
        # Findings under the present load.
        ("reversals", np.int64),
        # 0 once a step has been too long under the present load.
        ("grows", np.int64),
        ("good_integral", np.float64),
        ("good_offset", np.float64),
        ("good_power", np.float64),
        ("forbidden_power", np.float64),
        ("lost_at", np.float64),
        ("retried", np.int64),
        ("calm_error", np.float64),
        ("last_power", np.float64),
        ("last_integral", np.float64),
        # What the integral has grown by in the last decision interval.
        ("integral_growth", np.float64),
        ("winding", np.int64),
        ("starved_run", np.int64),
        ("starved_mark", np.float64),
        # Speed that was lost when a step was last reverted; infinite while none is lost.
        ("lost_speed", np.float64),
        ("climb", np.float64),
        ("regained", np.float64),
        ("worse", np.int64),
        ("worse_from", np.float64),
        ("confirmed", np.int64),
        # The angle at which the load last seemed to have changed during the search, and how often it has.
        ("jolted_at", np.float64),
        ("restarts", np.int64),
        ("waited", np.int64),
        ("widened", np.int64),
        # Whether a probe beyond the angle of rest is under way, or has found nothing.
        ("probe", np.int64),
        ("initial_power", np.float64),
        # Regulation of the speed by the angle. A gain of 0 excludes it.
        ("angle_proportional", np.float64),
        ("angle_integral_step", np.float64),
        ("angle_integral", np.float64),
        # Share of the gain, and its lower limit at base speed.
        ("angle_gain", np.float64),
        ("least_angle_gain", np.float64),
        # The current reference on its way to the limit.
        ("freed_reference", np.float64),
        ("freed_step", np.float64),
        # 0 once the angle could not regulate the speed under the present load.
        ("follows", np.int64),
        ("followed_power", np.float64),
        # 1 once a search upward from it has begun.
        ("compared", np.int64),
        # 1 once the load has seemed to become lighter in that search.
        ("lightened", np.int64),
        # Decision intervals of it, and the angle at which the search had come to rest before it.
        ("followed_intervals", np.int64),
        ("kept_offset", np.float64),
        ("kept_integral", np.float64),
        ("kept_power", np.float64),
        # Speed at which the peak EMF equals the nominal supply, and the present ratio of both.
        ("matched_speed", np.float64),
        ("emf_over_supply", np.float64),
    ],
    align=True,
)
"""Angles in rad electrical, speeds in rad/s, currents in A. Fields named `power` are current sums in A, which are
proportional to input power at constant supply voltage.
"""
