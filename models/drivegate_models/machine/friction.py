"""Friction of a shaft that turns."""

from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

Speed = TypeVar("Speed", float, npt.NDArray[np.float64])


class ShaftFriction(Protocol):
    """What the constants of every kind of drive state of friction."""

    @property
    def friction(self) -> float:
        """Torque at any speed (N m)."""

    @property
    def viscous_friction(self) -> float:
        """Torque over speed (N m s/rad)."""


def friction_torque(drive: ShaftFriction, speed: Speed) -> Speed:
    """Return the friction torque of a shaft at a speed (rad/s), without the core loss's drag (N m)."""
    return drive.friction + drive.viscous_friction * speed
