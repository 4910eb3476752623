"""Torque of the driven machine: what opposes the rotation, and a weight, whose sense does not depend on it."""

from __future__ import annotations

from math import sqrt
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined

LOCKED: Final = 0
"""A dynamometer maintains the shaft at the speed reference."""
CONSTANT_TORQUE: Final = 1
"""The same torque at every speed. It stops the shaft at standstill and never drives it backward."""
CONSTANT_POWER: Final = 2
"""Power over speed, limited to the torque at `SLOWEST`."""
FAN: Final = 3
"""Torque proportional to the square of speed."""
VEHICLE: Final = 4
"""A vehicle on a road; the factor is the road's grade, positive where the road rises in the forward direction."""
HOIST: Final = 5
"""A weight on a drum."""
SLOWEST: Final = 1.0
"""Speed below which the torque of a constant power load no longer increases (rad/s)."""


class Load(NamedTuple):
    kind: int
    """`LOCKED`, `CONSTANT_TORQUE`, `CONSTANT_POWER`, `FAN`, `VEHICLE` or `HOIST`."""
    size: float = 0.0
    """Torque (N m) or power (W); a vehicle's weight times its lever at the shaft (N m)."""
    speed: float = 1.0
    """Speed at which a fan demands `size` (rad/s); unused by the others."""
    rolling: float = 0.0
    """Rolling resistance of a vehicle as a share of its weight (1)."""
    drag: float = 0.0
    """Drag torque of a vehicle over the squared shaft speed (N m s2/rad2)."""
    inertia: float = 0.0
    """Inertia of the load at the shaft (kg m2)."""


@inlined
def drag_torque(load: Load, speed: float) -> float:
    """Return the magnitude of a vehicle's drag at a speed of the shaft (rad/s) (N m), 0 for other loads."""
    return load.drag * speed * speed


@inlined
def opposing_torque(load: Load, factor: float, speed: float) -> float:
    """Return the torque by which a load opposes the rotation, and holds a standing shaft (N m), at least 0.

    `factor`: factor on the size at this time (1); for a vehicle the grade, height over distance (1). `speed`: magnitude
    of the shaft's speed (rad/s). For a vehicle it is the sum of rolling resistance and drag; for a hoist it is 0.
    """
    if load.kind == CONSTANT_TORQUE:
        return factor * load.size
    if load.kind == CONSTANT_POWER:
        return factor * load.size / max(speed, SLOWEST)
    if load.kind == FAN:
        return factor * load.size * (speed / load.speed) ** 2
    if load.kind == VEHICLE:
        return load.size / sqrt(1.0 + factor * factor) * load.rolling + drag_torque(load, speed)
    return 0.0


@inlined
def weight_torque(load: Load, factor: float) -> float:
    """Return the torque by which a weight turns the shaft backward (N m), 0 without a weight.

    It is the same at every speed, also at standstill and backward. `factor`: as for `opposing_torque`; on a negative
    grade a vehicle's weight turns the shaft forward.
    """
    if load.kind == HOIST:
        return factor * load.size
    if load.kind == VEHICLE:
        return load.size / sqrt(1.0 + factor * factor) * factor
    return 0.0
