"""What a faulty controller makes of the temperature of its windings."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from drivegate_models.compilation.kernels import inlined

HEAT: Final = (
    # Offset of the sensed temperature (K).
    ("temperature_added", np.float64),
    # Sensed temperature from which the torque reference is limited to a torque (N m), 0 for never, and that below which
    # it no longer is (deg C); 1 while it is.
    ("cut_from", np.float64),
    ("cut_until", np.float64),
    ("cut_torque", np.float64),
    ("is_cut", np.int64),
)
"""Fields of the state."""


@inlined
def perturb_heat(state: Any, sense: Any, perturbed: Any) -> None:
    """Add an offset to the sensed temperature, and limit the torque reference of hot windings."""
    perturbed.winding_temperature = sense.winding_temperature + state.temperature_added
    if state.cut_from <= 0.0:
        return
    if sense.winding_temperature >= state.cut_from:
        state.is_cut = 1
    elif sense.winding_temperature < state.cut_until:
        state.is_cut = 0
    if state.is_cut == 1:
        perturbed.reference = min(max(perturbed.reference, -state.cut_torque), state.cut_torque)
