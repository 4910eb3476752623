"""The shaft over one control period: where it has turned to, and how fast it turns then."""

from __future__ import annotations

from math import floor, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger


@inlined
def within_a_turn(angle: float) -> float:
    """Return an angle less whole turns.

    Parameters
    ----------
    angle : float
        Electrical angle (rad).

    Returns
    -------
    float
        The same in [0, 2 pi) but for rounding.
    """
    return angle - 2.0 * pi * floor(angle * (0.5 / pi))


@inlined
def speed_after(
    drive: Any,
    run: Any,
    inertia: float,
    speed: float,
    load: float,
    period: NDArray[np.float64],
    length: float,
) -> float:
    """Return the speed behind a control period, through which it was taken as constant.

    Parameters
    ----------
    drive : named tuple
        The drive; its `friction` and `viscous_friction`.
    run : record of RUN_RECORD
        Its `kinetic_residual` is updated.
    inertia : float
        Inertia of rotor and load (kg m2).
    speed : float
        Speed in the period (rad/s).
    load : float
        Torque of the load in it (N m).
    period : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the period.
    length : float
        Its length (s).

    Returns
    -------
    float
        (rad/s).
    """
    resisting = load + drive.friction + drive.viscous_friction * speed
    change = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE] - resisting * length) / inertia
    # Load and friction hold a shaft at standstill; they never drive it backward.
    following: float = max(speed + change, 0.0)
    run.kinetic_residual += 0.5 * inertia * (following - speed) ** 2
    return following
