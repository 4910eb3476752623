"""Torque of the driven machine."""

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
"""A vehicle on a road; the factor is the road's grade."""
HOIST: Final = 5
"""A weight on a drum: its torque keeps its sense of rotation, also at standstill, and can drive the shaft."""
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
def weight_torque(load: Load, factor: float) -> float:
    """Return the torque by which a hoist's weight turns the shaft backward (N m), 0 for other loads."""
    return factor * load.size if load.kind == HOIST else 0.0


@inlined
def load_torque(load: Load, factor: float, speed: float) -> float:
    """Return the load's torque at a speed.

    `factor`: factor on the size at this time (1); for a vehicle the grade, height over distance (1). `speed`: shaft
    speed (rad/s), at least 0. Result: torque against the rotation (N m), 0 for a hoist. For a vehicle it is the sum of
    its weight along the road, its rolling resistance and its drag.
    """
    if load.kind == CONSTANT_TORQUE:
        return factor * load.size
    if load.kind == CONSTANT_POWER:
        return factor * load.size / max(speed, SLOWEST)
    if load.kind == FAN:
        return factor * load.size * (speed / load.speed) ** 2
    if load.kind == VEHICLE:
        weight = load.size / sqrt(1.0 + factor * factor)
        return weight * (load.rolling + factor) + load.drag * speed * speed
    return 0.0
