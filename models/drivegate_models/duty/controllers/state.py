"""State of the field-oriented controller, one record in the buffer that the caller provides."""

from __future__ import annotations

from typing import Final

import numpy as np

FOC_STATE: Final = np.dtype(
    [
        # Constants, set by reset.
        ("regulates_speed", np.int64),
        ("pole_pairs", np.float64),
        ("resistance", np.float64),
        ("direct_inductance", np.float64),
        ("quadrature_inductance", np.float64),
        ("magnet_flux", np.float64),
        ("current_limit", np.float64),
        # At the current limit, where the voltage is free.
        ("greatest_torque", np.float64),
        # Time from sampling to the middle of the period in which the answer acts.
        ("lead", np.float64),
        ("speed_gain", np.float64),
        ("speed_integral_step", np.float64),
        ("direct_gain", np.float64),
        ("quadrature_gain", np.float64),
        ("direct_integral_step", np.float64),
        ("quadrature_integral_step", np.float64),
        ("weakening_step", np.float64),
        # Regulators.
        ("speed_integral", np.float64),
        ("direct_integral", np.float64),
        ("quadrature_integral", np.float64),
        ("weakening", np.float64),
    ],
    align=True,
)
"""In SI units; speeds are electrical, but for the speed regulator's gains, which make torque of the shaft's."""
