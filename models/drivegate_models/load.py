"""Torque that the driven machine asks for."""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation import inlined

LOCKED: Final = 0
"""A dynamometer holds the shaft at the speed reference."""
CONSTANT_TORQUE: Final = 1
"""The same torque at every speed; it holds the shaft at standstill and never drives it backward."""
CONSTANT_POWER: Final = 2
"""Power over speed, limited to the torque at `SLOWEST`."""
FAN: Final = 3
"""Torque with the square of speed."""
SLOWEST: Final = 1.0
"""Speed below which a constant power load asks for no more torque (rad/s)."""


class Load(NamedTuple):
    """A load: its kind and its size."""

    kind: int
    """`LOCKED`, `CONSTANT_TORQUE`, `CONSTANT_POWER` or `FAN`."""
    size: float
    """Torque (N m) or power (W)."""
    speed: float
    """Speed at which a fan asks for `size` (rad/s); unused by the others."""


@inlined
def load_torque(load: Load, factor: float, speed: float) -> float:
    """Return the load's torque.

    Parameters
    ----------
    load : Load
        Kind and size.
    factor : float
        Scale of the size at this time (1).
    speed : float
        Shaft speed (rad/s), at least 0.

    Returns
    -------
    float
        Torque against the rotation (N m).
    """
    if load.kind == CONSTANT_TORQUE:
        return factor * load.size
    if load.kind == CONSTANT_POWER:
        return factor * load.size / max(speed, SLOWEST)
    if load.kind == FAN:
        return factor * load.size * (speed / load.speed) ** 2
    return 0.0
