"""Angle and speed of the shaft over one control period."""

from __future__ import annotations

from math import floor, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger


@inlined
def whole_turns(angle: float) -> int:
    """Return the number of whole turns in an angle (rad), negative for a negative angle."""
    return floor(angle * (0.5 / pi))


@inlined
def within_a_turn(angle: float) -> float:
    """Return an angle minus whole turns.

    `angle`: any angle, electrical or of the shaft (rad). Result: the angle in [0, 2 pi), except for rounding.
    """
    return angle - 2.0 * pi * whole_turns(angle)


@inlined
def shown_angle(angle: float) -> float:
    """Return the angle of the shaft as a controller senses it.

    `angle`: angle of the shaft, including whole turns (rad). Result: the angle in [0, 2 pi), with rounding too.
    """
    within = within_a_turn(angle)
    return within if 0.0 <= within < 2.0 * pi else 0.0


@inlined
def held_speed(speed: float, gained: float) -> float:
    """Return the constant speed at which a control period is computed: that of its middle, extrapolated.

    The error of a run then falls with the square of the period. With the speed of the period's start it would fall
    only in proportion to the period.

    `speed`: speed at the start of the period (rad/s). `gained`: change of speed in the preceding period (rad/s).
    Result: speed (rad/s), negative if a decelerating shaft would come to rest within the period.
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
    """Return the change of speed in a control period.

    - `drive`: its `friction` (N m) and `viscous_friction` (N m s/rad) are used.
    - `inertia`: inertia of rotor and load (kg m2).
    - `speed`: speed at the start of the period (rad/s).
    - `held`: speed at which the period was computed (rad/s).
    - `load`: load torque in the period (N m).
    - `period`, shape (ledger.ENTRIES,): exact integrals over the period.
    - `length`: length of the period (s).
    """
    resisting = load + drive.friction + drive.viscous_friction * held
    change = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE] - resisting * length) / inertia
    # Load and friction stop a shaft; they never drive it backward.
    gained: float = max(change, -speed)
    return gained
