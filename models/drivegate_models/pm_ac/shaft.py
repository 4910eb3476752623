"""The shaft of a PM AC drive over one control period: it may turn either way, and friction never drives it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.plant.drive import PmAcDrive


@inlined
def speed_change(
    drive: PmAcDrive,
    inertia: float,
    speed: float,
    load: float,
    weight: float,
    period: NDArray[np.float64],
    length: float,
) -> float:
    """Return the change of the shaft's speed in a control period.

    Parameters
    ----------
    drive : PmAcDrive
        Its friction constants are used.
    inertia : float
        Inertia of rotor and load (kg m2).
    speed : float
        Speed at the start of the period (rad/s).
    load : float
        Magnitude of the load's torque, which opposes the shaft's rotation (N m).
    weight : float
        Torque that turns the shaft backward, whichever way it turns (N m).
    period : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the period.
    length : float
        Length of the period (s).

    Returns
    -------
    float
        Change of speed (rad/s).
    """
    driving = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE]) / length
    driving -= drive.viscous_friction * speed + weight
    opposing = load + drive.friction
    # Load and friction oppose a turning shaft and stop it; they never drive it.
    mobility = length / inertia
    forward = float((driving - opposing) * mobility)
    backward = float((driving + opposing) * mobility)
    if speed > 0.0:
        return max(forward, -speed) if driving >= -opposing else forward
    if speed < 0.0:
        return min(backward, -speed) if driving <= opposing else backward
    return max(forward, 0.0) + min(backward, 0.0)
