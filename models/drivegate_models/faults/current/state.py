"""State of the faulty controllers, and the faults that are more than a changed constant.

A faulty controller is a built-in one with one known fault. The check that is named for the fault must catch it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate_models.contract.current.records import SENSE
from drivegate_models.controllers.current.state import CONTROLLER_STATE

NO_FAULT: Final = 0
"""The built-in controller as it is, or with other constants."""

SUM_MIRRORED: Final = 1
"""The search sees a current sum that falls where the true one rises, `size` less the true one."""
SUM_WITHOUT_MAGNITUDES: Final = 2
"""The phase currents are added with their signs."""
SUM_WITHOUT_LAST_PHASE: Final = 3
"""The last phase is left out of the current sum."""
SUM_OVERFLOWS: Final = 4
"""The current sum is a 16-bit number of milliamperes and wraps around."""

NEVER_RESTS: Final = 10
"""The search goes on from the optimum."""
STALE_POWER: Final = 11
"""After a change of the speed reference the search compares with the power at the old speed for good."""
SATURATION_IGNORED: Final = 12
"""A current reference at its limit is not noticed."""
NO_WALK_BACK: Final = 13
"""A step that costs regulation is not taken back."""
NEVER_REARMS: Final = 14
"""The search holds what it has found, whatever the load does."""
FALLING_LOAD_IGNORED: Final = 15
"""The search starts anew when the load has risen, not when it has fallen."""
NO_ANTI_WINDUP: Final = 16
"""The regulator's integral goes on while its output is limited."""
ANGLE_CAPPED: Final = 17
"""The angle stays at or below `size`, and so does the search."""
LINE_IS_LIMIT: Final = 18
"""The angle is never raised beyond the initial one."""

ADVANCES_BELOW_BASE: Final = 20
"""The advance angle is `size` instead of zero below base speed."""
BOOST_BEHIND_LIMITS: Final = 21
"""Far from its reference, speed error times `size` is added to an angle that is limited already."""
DELAYED: Final = 22
"""Current reference and angle are given one control period late."""
RIPPLING: Final = 23
"""The current reference is moved up and down by `size`, 125 times a second."""
DRIFTS: Final = 24
"""The angle found moves on, by `size` a second."""
NOMINAL_TABLE: Final = 25
"""The angle comes from a table made for the nominal drive."""
TRUSTS_SUPPLY: Final = 26
"""The angle is raised by `size` in every step whose supply differs from that of the step before."""
LATCHES_AT_STANDSTILL: Final = 27
"""After one reading of no speed the angle stays zero."""
REFERENCE_BELOW_ZERO: Final = 28
"""The current reference is not limited at zero."""
ESTIMATE_SCALED: Final = 29
"""The estimate of the input power is multiplied by `size`."""
ESTIMATE_AT_NOMINAL_SUPPLY: Final = 30
"""The estimate takes the supply for nominal."""
SLOW: Final = 31
"""Every step computes in vain, `size` times."""
BLIND_SPOT: Final = 32
"""The angle is the initial one, whatever the search says, in a region of speeds."""
UNLIMITED_LINE: Final = 33
"""The line of initial angles, and the angle that follows from it, have no limits."""

STEPS_OVERFLOW: Final = 40
"""The search starts anew where a count of control periods wraps around, at `size`."""
MILLISECONDS_OVERFLOW: Final = 41
"""The search starts anew where a count of milliseconds wraps around, at `size`."""
ALWAYS_DUE: Final = 42
"""From the time `size` on a decision is due at every step."""
CATCHES_UP: Final = 43
"""Decisions are due at multiples of their period since time zero, and those missed are made up for."""
INTEGRAL_IN_STEPS: Final = 44
"""The regulator's integral moves by whole steps of `size`, cut off."""
SPEED_IN_STEPS: Final = 45
"""The speed is seen in whole steps of `size`, cut off."""
ERROR_OVERFLOWS: Final = 46
"""The speed error wraps around beyond `size`."""
POWER_SUM_OVERFLOWS: Final = 47
"""The sum of a decision interval's current sums wraps around at `size`."""
COUNT_OVERFLOWS: Final = 48
"""The count of a decision interval's steps wraps around at `size`."""
ANGLE_IN_STEPS: Final = 49
"""The angle is given in whole steps of `size`, cut off."""
REARMS_COUNTED: Final = 50
"""When the search has started anew `size` times the angle is the initial one for good."""

SPEED_FILTERED: Final = 60
"""The speed passes a low-pass filter that takes over the share `size` in each step."""
BASE_SPEED_FILTERED: Final = 61
"""Whether the speed is below base speed is told by such a filter."""
SPEED_FILTER_STICKS: Final = 62
"""The speed passes a filter of whole numbers, which no difference below `size` moves."""
ESTIMATE_FILTERED: Final = 63
"""The estimate of the input power passes such a filter."""
SUM_FILTERED: Final = 64
"""The search sees the current sum through such a filter."""
SUPPLY_FILTERED: Final = 65
"""The estimate takes the supply from such a filter."""

DIFFERENTIATED: Final = 70
"""The speed's change in a step is taken for that in the time `size`, and damped with the inertia `extent`."""
SLEWED: Final = 71
"""The current reference moves by `size` in a step at most."""

HEAT_KEPT: Final = 80
"""After `size` seconds under load, added up without cooling, the current is limited for good."""
HEAT_IN_STEPS: Final = 81
"""The same after `size` control periods."""
DERATES_IN_TURNS: Final = 82
"""After `size` seconds under load the limit of the current comes and goes twice a second."""
PEAK_TRIPS: Final = 83
"""After `size` seconds at its limit on end, the current is limited further for good."""

CORNER_WITHOUT_LIMIT: Final = 90
"""The angle is `size` in a region of speeds, with less current than `extent`, once the search holds."""
WRONG_ROW: Final = 91
"""The angle is `size` or more in a region of speeds."""
REFERENCE_FLOOR: Final = 92
"""The current reference is `size` or more above a speed."""
SWELL_TRIPS: Final = 93
"""A supply of more than `size` times the nominal one limits the current for good."""
SPEED_CAPPED: Final = 94
"""The speed reference is taken for `size` where it is above."""
STOP_LATCHES: Final = 95
"""After a speed reference of zero the angle stays zero."""

LEARNS: Final = 100
"""The search begins at the offset that was found last."""
RUNS_COUNTED: Final = 101
"""From its run number `size` on, an instance searches nothing."""

LOST_CURRENT_TRIPS: Final = 110
"""One sample of a sum below `extent`, where there was one above `size`, sets the angle to zero for good."""
OVERSPEED_TRIPS: Final = 111
"""One sample of a speed more than `size` times its reference limits the current for good."""
LOWEST_SUPPLY_KEPT: Final = 112
"""The supply is taken for the lowest one that was ever seen."""
LOST_SPEEDS_COUNTED: Final = 113
"""After `size` samples without any speed, in all, the current is limited for good."""
ONE_PHASE_FOR_ALL: Final = 114
"""The search takes the magnitude of the first phase's current for all of them."""

ANGLE_CYCLES: Final = 120
"""The angle goes up and down by `size`, once in two seconds."""
SPEED_BIASED: Final = 121
"""The speed is seen lower by `size`."""
TORQUE_CYCLES: Final = 122
"""The torque goes up and down by the share `size`, once a second, well above base speed."""
RESTS_BESIDE: Final = 123
"""The angle is held higher than the one found by `size`."""
SETTLES_LATE: Final = 124
"""The angle is higher by `extent` up to `size` seconds after the start or a change of the speed reference."""

TABLE_ROWS: Final = 9
"""Rows of the table of angles for the nominal drive."""

FAULTY_STATE: Final = np.dtype(
    [
        ("controller", CONTROLLER_STATE),
        # As the step found it, and what the step is shown.
        ("before", CONTROLLER_STATE),
        ("sense", SENSE),
        # The fault and how large it is, set by reset; speeds of a region in rpm.
        ("fault", np.int64),
        ("size", np.float64),
        ("extent", np.float64),
        ("first_rpm", np.float64),
        ("last_rpm", np.float64),
        # A table of angles for the nominal drive.
        ("table_rpm", np.float64, (TABLE_ROWS,)),
        ("table_degrees", np.float64, (TABLE_ROWS,)),
        # What the fault remembers.
        ("steps", np.int64),
        ("latched", np.int64),
        ("tally", np.int64),
        ("memory", np.float64),
        # The current sum as the sensors saw it.
        ("true_sum", np.float64),
        ("late_reference", np.float64),
        ("late_angle", np.float64),
    ],
    align=True,
)
"""Units as in `CONTROLLER_STATE`; `size` and `extent` in those of their fault."""
