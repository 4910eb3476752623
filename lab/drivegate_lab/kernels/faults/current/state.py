"""State of the faulty controllers, and the faults that are more than a changed constant.

A faulty controller is a built-in one with one known fault. The check named for the fault must detect it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate_lab.kernels.faults.broken_coupling import WATCHED_SHAFT
from drivegate_models.contract.current.records import SENSE
from drivegate_models.controllers.current.state import CONTROLLER_STATE

NO_FAULT: Final = 0
"""The built-in controller, unchanged or with other constants."""

SUM_MIRRORED: Final = 1
"""The search uses `size` minus the true current sum, which falls where the true one rises."""
SUM_WITHOUT_MAGNITUDES: Final = 2
"""The phase currents are added with their signs."""
SUM_WITHOUT_LAST_PHASE: Final = 3
"""The current sum omits the last phase."""
SUM_OVERFLOWS: Final = 4
"""The current sum is a 16-bit number of milliamperes and wraps around."""

NEVER_RESTS: Final = 10
"""The search continues from the optimum."""
STALE_POWER: Final = 11
"""After a change of the speed reference, the search permanently compares with the power at the old speed."""
SATURATION_IGNORED: Final = 12
"""A current reference at its limit is not detected."""
NO_WALK_BACK: Final = 13
"""A step that costs regulation is not reverted."""
NEVER_REARMS: Final = 14
"""The search holds its angle, whatever the load does."""
FALLING_LOAD_IGNORED: Final = 15
"""The search restarts when the load has risen, but not when it has fallen."""
NO_ANTI_WINDUP: Final = 16
"""The regulator's integral continues while its output is limited."""
ANGLE_CAPPED: Final = 17
"""The angle, and the search, are limited to at most `size`."""
LINE_IS_LIMIT: Final = 18
"""The angle is never raised beyond the initial one."""

ADVANCES_BELOW_BASE: Final = 20
"""The advance angle is `size` instead of zero below base speed."""
BOOST_BEHIND_LIMITS: Final = 21
"""Far from the speed reference, speed error times `size` is added to the angle after its limits."""
DELAYED: Final = 22
"""Current reference and angle are delayed by one control period."""
RIPPLING: Final = 23
"""The current reference alternates by plus and minus `size`, 125 times per second."""
DRIFTS: Final = 24
"""The angle found drifts by `size` per second."""
NOMINAL_TABLE: Final = 25
"""The angle comes from a table made for the nominal drive."""
TRUSTS_SUPPLY: Final = 26
"""The angle is raised by `size` in every step whose supply differs from that of the preceding step."""
LATCHES_AT_STANDSTILL: Final = 27
"""After one reading of zero speed, the angle remains zero."""
REFERENCE_BELOW_ZERO: Final = 28
"""The current reference is not limited at zero."""
ESTIMATE_SCALED: Final = 29
"""The estimate of the input power is multiplied by `size`."""
ESTIMATE_AT_NOMINAL_SUPPLY: Final = 30
"""The estimate assumes nominal supply voltage."""
SLOW: Final = 31
"""Every step wastes time on `size` divisions."""
BLIND_SPOT: Final = 32
"""In a region of speeds the angle is the initial one, whatever the search finds."""
UNLIMITED_LINE: Final = 33
"""The line of initial angles, and the resulting angle, have no limits."""

STEPS_OVERFLOW: Final = 40
"""The search restarts when a count of control periods wraps around, at `size`."""
MILLISECONDS_OVERFLOW: Final = 41
"""The search restarts when a count of milliseconds wraps around, at `size`."""
ALWAYS_DUE: Final = 42
"""After the time `size`, a decision is due in every step."""
CATCHES_UP: Final = 43
"""Decisions are due at multiples of their period since time zero, and missed ones are caught up."""
INTEGRAL_IN_STEPS: Final = 44
"""The regulator's integral moves by whole steps of `size`, truncated."""
SPEED_IN_STEPS: Final = 45
"""The measured speed is truncated to whole steps of `size`."""
ERROR_OVERFLOWS: Final = 46
"""The speed error wraps around beyond `size`."""
POWER_SUM_OVERFLOWS: Final = 47
"""The sum of a decision interval's current sums wraps around at `size`."""
COUNT_OVERFLOWS: Final = 48
"""The count of a decision interval's steps wraps around at `size`."""
ANGLE_IN_STEPS: Final = 49
"""The angle is truncated to whole steps of `size`."""
REARMS_COUNTED: Final = 50
"""After `size` restarts of the search, the angle is permanently the initial one."""

SPEED_FILTERED: Final = 60
"""The speed passes a low-pass filter that adopts the share `size` of its input in each step."""
BASE_SPEED_FILTERED: Final = 61
"""The comparison with base speed uses a speed from such a filter."""
SPEED_FILTER_STICKS: Final = 62
"""The speed passes an integer filter, which ignores differences below `size`."""
ESTIMATE_FILTERED: Final = 63
"""The estimate of the input power passes such a filter."""
SUM_FILTERED: Final = 64
"""The search uses the current sum after such a filter."""
SUPPLY_FILTERED: Final = 65
"""The estimate uses the supply voltage after such a filter."""

DIFFERENTIATED: Final = 70
"""The speed's change per step is divided by the time `size`, and damped with the inertia `extent`."""
SLEWED: Final = 71
"""The current reference moves by at most `size` per step."""

HEAT_KEPT: Final = 80
"""After `size` seconds under load, summed without cooling, the current is limited permanently."""
HEAT_IN_STEPS: Final = 81
"""The same after `size` control periods."""
DERATES_IN_TURNS: Final = 82
"""After `size` seconds under load, a lower current limit switches on and off twice per second."""
PEAK_TRIPS: Final = 83
"""After `size` continuous seconds at its limit, the current is limited further, permanently."""

CORNER_WITHOUT_LIMIT: Final = 90
"""In a region of speeds, with less current than `extent`, the angle is `size` once the search holds."""
WRONG_ROW: Final = 91
"""In a region of speeds, the angle is at least `size`."""
REFERENCE_FLOOR: Final = 92
"""Above a speed, the current reference is at least `size`."""
SWELL_TRIPS: Final = 93
"""A supply voltage of more than `size` times the nominal one limits the current permanently."""
SPEED_CAPPED: Final = 94
"""The speed reference is limited to `size`."""
STOP_LATCHES: Final = 95
"""After a speed reference of zero, the angle remains zero."""

BEYOND_RAMPED: Final = 96
"""Above a speed `extent`, the speed reference changes by at most `size` per step."""
BEYOND_TRIPS: Final = 97
"""A change of the speed reference above `size` limits the current permanently."""
IDLE_TRIPS: Final = 98
"""After `size` continuous seconds without a current reference while turning, the current is limited permanently."""
IDLE_LATCHES: Final = 99
"""After `size` such seconds, the angle remains zero."""

LEARNS: Final = 100
"""The search begins at the offset found last."""
RUNS_COUNTED: Final = 101
"""From its run number `size` on, an instance does not search."""

LOST_CURRENT_TRIPS: Final = 110
"""One sample of a current sum below `extent`, after one above `size`, sets the angle to zero permanently."""
OVERSPEED_TRIPS: Final = 111
"""One sample of a speed above `size` times its reference limits the current permanently."""
LOWEST_SUPPLY_KEPT: Final = 112
"""The lowest supply voltage ever measured is used."""
LOST_SPEEDS_COUNTED: Final = 113
"""After `size` samples of zero speed in total, the current is limited permanently."""
ONE_PHASE_FOR_ALL: Final = 114
"""The search uses the magnitude of the first phase's current for all phases."""
BREAKING_AWAY_TRIPS: Final = 115
"""An acceleration of `size` times the greatest one toward a reference limits the current permanently."""

ANGLE_CYCLES: Final = 120
"""The angle oscillates by `size`, with a period of two seconds."""
SPEED_BIASED: Final = 121
"""The measured speed is lower by `size`."""
TORQUE_CYCLES: Final = 122
"""Well above base speed, the torque oscillates by the share `size`, once per second."""
RESTS_BESIDE: Final = 123
"""The angle is held above the one found, by `size`."""
SETTLES_LATE: Final = 124
"""The angle is higher by `extent` until `size` seconds after the start or a change of the speed reference."""

TABLE_ROWS: Final = 9
"""Rows of the table of angles for the nominal drive."""

FAULTY_STATE: Final = np.dtype(
    [
        ("controller", CONTROLLER_STATE),
        # The state before the step, and the Sense passed to the step.
        ("before", CONTROLLER_STATE),
        ("sense", SENSE),
        # The fault and its size, set by reset; speeds of a region in rpm.
        ("fault", np.int64),
        ("size", np.float64),
        ("extent", np.float64),
        ("first_rpm", np.float64),
        ("last_rpm", np.float64),
        # A table of angles for the nominal drive.
        ("table_rpm", np.float64, (TABLE_ROWS,)),
        ("table_degrees", np.float64, (TABLE_ROWS,)),
        # State of the fault.
        ("steps", np.int64),
        ("latched", np.int64),
        ("tally", np.int64),
        ("memory", np.float64),
        # The current sum as measured.
        ("true_sum", np.float64),
        ("late_reference", np.float64),
        ("late_angle", np.float64),
        ("shaft", WATCHED_SHAFT),
    ],
    align=True,
)
"""Units as in `CONTROLLER_STATE`; `size` and `extent` in the units of their fault."""
