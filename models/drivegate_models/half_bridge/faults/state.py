"""State of the faulty controllers, and the faults that are more than a changed constant.

A faulty controller is a built-in one with one known fault. The check that is named for the fault must catch it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate_models.contract.outer_loop.records import SENSE
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE

NO_FAULT: Final = 0
"""The built-in controller as it is, or with other constants."""

SUM_MIRRORED: Final = 1
"""The search sees a current sum that falls where the true one rises."""
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
"""The angle is the initial one, whatever the search says, between 1230 and 1290 rpm."""
UNLIMITED_LINE: Final = 33
"""The line of initial angles, and the angle that follows from it, have no limits."""

FAULTY_STATE: Final = np.dtype(
    [
        ("controller", CONTROLLER_STATE),
        # As the step found it, and what the step is shown.
        ("before", CONTROLLER_STATE),
        ("sense", SENSE),
        # The fault and how large it is, set by reset.
        ("fault", np.int64),
        ("size", np.float64),
        # What the fault remembers.
        ("steps", np.int64),
        ("latched", np.int64),
        ("memory", np.float64),
        ("late_reference", np.float64),
        ("late_angle", np.float64),
    ],
    align=True,
)
"""Units as in `CONTROLLER_STATE`; `size` in those of its fault."""
