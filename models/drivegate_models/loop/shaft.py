"""The shaft over one control period: where it has turned to, and how fast it turns then."""

from __future__ import annotations

from math import floor, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger


@inlined
def whole_turns(angle: float) -> int:
    """Return how many whole turns lie below an angle.

    Parameters
    ----------
    angle : float
        The angle (rad).

    Returns
    -------
    int
        Below zero for a negative angle (1).
    """
    return floor(angle * (0.5 / pi))


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
    return angle - 2.0 * pi * whole_turns(angle)


@inlined
def shown_angle(angle: float) -> float:
    """Return an angle of the shaft as controllers are shown it.

    Parameters
    ----------
    angle : float
        Angle of the shaft, whole turns included (rad).

    Returns
    -------
    float
        The same in [0, 2 pi), whatever is rounded.
    """
    within = within_a_turn(angle)
    return within if 0.0 <= within < 2.0 * pi else 0.0


@inlined
def held_speed(speed: float, gained: float) -> float:
    """Return the speed at which a control period is computed: that of its middle, as far as the last period tells.

    The error of a run then falls with the square of the period; with the speed of the period's start it falls with the
    period.

    Parameters
    ----------
    speed : float
        Speed at the start of the period (rad/s).
    gained : float
        What it gained in the period before (rad/s).

    Returns
    -------
    float
        (rad/s); below zero where a shaft that has slowed down would come to rest within the period.
    """
    return speed + 0.5 * gained


@inlined
def speed_gained(
    drive: Any,
    inertia: float,
    speed: float,
    held: float,
    load: float,
    period: NDArray[np.float64],
    length: float,
) -> float:
    """Return what the speed gains in a control period.

    Parameters
    ----------
    drive : named tuple
        The drive; its `friction` and `viscous_friction`.
    inertia : float
        Inertia of rotor and load (kg m2).
    speed : float
        Speed at the start of the period (rad/s).
    held : float
        Speed at which the period was computed (rad/s).
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
    resisting = load + drive.friction + drive.viscous_friction * held
    change = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE] - resisting * length) / inertia
    # Load and friction hold a shaft at standstill; they never drive it backward.
    gained: float = max(change, -speed)
    return gained
