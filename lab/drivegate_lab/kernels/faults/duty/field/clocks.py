"""Faults of clocks that wrap around, and of times in single precision."""

from __future__ import annotations

from math import floor
from typing import Any, Final

import numpy as np

from drivegate_lab.kernels.faults.duty.field import state as faults
from drivegate_models.compilation.kernels import inlined

# Time over which a reference is ramped up by a signed clock, in control periods.
_RAMP_PERIODS: Final = 100.0


@inlined
def alter_by_clock(state: Any, fault: int) -> None:
    """Change the controller's copy of the Sense, or its integral, by a fault of its clock."""
    sense = state.sense
    time, before = sense.time, state.time_before
    if fault == faults.CLOCK_NEGATIVE:
        shown = time - state.size * floor(time / state.size + 0.5)
        sense.reference *= min(max(shown / (_RAMP_PERIODS * state.control_period), 0.0), 1.0)
    elif fault == faults.CLOCK_RESTARTS:
        if state.steps > 1 and floor(time / state.size) != floor(before / state.size):
            state.memory = time
            state.stage = 1
        if state.stage == 1:
            sense.reference *= min((time - state.memory) / state.extent, 1.0)
    elif fault == faults.CLOCK_LEAPS:
        if state.steps > 1 and floor(time / state.size) != floor(before / state.size):
            state.controller.speed_integral = -state.controller.greatest_torque
            state.controller.quadrature_integral = 0.0
    elif fault == faults.CLOCK_COARSE:
        late = time - state.size * float(np.float32(time / state.size))
        sense.angle += late * sense.speed
