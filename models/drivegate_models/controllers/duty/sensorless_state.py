"""State of the field-oriented controller without a position sensor."""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate_models.controllers.duty.state import FOC_STATE

WATCHING: Final = 0
"""All legs are off, and the terminals show whether the shaft turns."""
ALIGNING: Final = 1
"""A current along two directions in turn moves the rotor to a known angle."""
RAMPING: Final = 2
"""A current vector turns at a given speed, and the rotor follows."""
RUNNING: Final = 3
"""Field-oriented control by the observed angle and speed."""

SENSORLESS_STATE: Final = np.dtype(
    [
        # Machine data, modulation and regulators, as of `foc`.
        ("machine", FOC_STATE),
        # Mode, its age in control periods, and the code of the first fault.
        ("mode", np.int64),
        ("age", np.int64),
        ("fault", np.int64),
        # Speeds are electrical (rad/s). The least one for steady running, that of handover over it, bandwidth of the
        # observer's phase-locked loop, and its gain without rotation (1/s).
        ("least_speed", np.float64),
        ("handover_speed", np.float64),
        ("bandwidth", np.float64),
        ("still_gain", np.float64),
        # Start: its current (A), the period of the rotor's swing (s), control periods along both directions, the
        # acceleration of the ramp (rad/s2), the virtual resistance that damps the swing (ohm), and the shares by which
        # the induced voltage and its mean follow in a control period.
        ("start_current", np.float64),
        ("swing_period", np.float64),
        ("align_periods", np.int64),
        ("acceleration", np.float64),
        ("damping", np.float64),
        ("fast_share", np.float64),
        ("slow_share", np.float64),
        # The current vector of a start: angle (rad), size (A), speed, sense of rotation, and the induced voltage along
        # and across it, followed and mean (V).
        ("field", np.float64),
        ("current", np.float64),
        ("field_speed", np.float64),
        ("sense_of_start", np.float64),
        ("induced", np.float64, (2,)),
        ("mean_induced", np.float64, (2,)),
        # Observer: angle (rad), speed, and flux linkage (V s, stationary frame).
        ("angle", np.float64),
        ("speed", np.float64),
        ("along_flux", np.float64),
        ("across_flux", np.float64),
        # Error of that flux along the magnet over the flux of the currents (1).
        ("flux_error", np.float64),
        # Currents (A) and terminal voltages (V) of the step before, in the stationary frame.
        ("along_before", np.float64),
        ("across_before", np.float64),
        ("along_terminal", np.float64),
        ("across_terminal", np.float64),
        # What the terminal voltage has turned while the legs are off (rad), and its sum of magnitudes (V).
        ("turned", np.float64),
        ("magnitudes", np.float64),
        # Control periods for which observer and field agree, and for which the rotor looks lost; bounds of both.
        ("agreed", np.int64),
        ("lost", np.int64),
        ("agreed_periods", np.int64),
        ("lost_periods", np.int64),
    ],
    align=True,
)
"""In SI units; what is not named is the shaft's."""
