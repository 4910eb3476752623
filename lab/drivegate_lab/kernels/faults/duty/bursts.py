"""A faulty controller that burns the energy of braking in its windings by a two-point regulator of the link."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

import numpy as np

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined

_ALLOWED: Final = 0.95

BURSTS: Final = (
    # Link voltage from which d-axis current is burnt, 0 for never, and that below which it no longer is (V); this
    # current, and the greatest of a phase (A); 1 while it is burnt.
    ("bursts_from", np.float64),
    ("bursts_until", np.float64),
    ("burst_current", np.float64),
    ("bursts_within", np.float64),
    ("is_bursting", np.int64),
)
"""Fields of the state."""


@inlined
def burst_current(state: Any, sense: Any) -> float:
    """Return the d-axis current that is hidden from the controller (A), which weakens by as much more."""
    if state.bursts_from <= 0.0:
        return 0.0
    square = 0.0
    for phase in range(3):
        square += double_at(sense.phase_currents, phase) ** 2
    is_within = sqrt(2.0 / 3.0 * square) <= _ALLOWED * state.bursts_within
    if sense.supply_voltage < state.bursts_until or not is_within:
        state.is_bursting = 0
    elif sense.supply_voltage >= state.bursts_from:
        state.is_bursting = 1
    return float(state.burst_current) if state.is_bursting == 1 else 0.0
