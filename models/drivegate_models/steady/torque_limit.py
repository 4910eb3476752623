"""The torque at the current limit: over the advance angle, and its maximum."""

from __future__ import annotations

from math import radians
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivegate_models.steady.angle_search import torque_at_limit, torque_demand
from drivegate_models.steady.plant import AnyDrive

HIGHEST_DEGREES: int = 90
"""Maximum advance angle (deg), as everywhere in the oracle."""
_ANGLE_TOLERANCE = 1e-8


class GreatestTorque(NamedTuple):
    """The maximum torque at the current limit."""

    torque: float
    """Mean electromagnetic torque (N m)."""
    advance: float
    """Advance angle of the maximum torque (rad electrical)."""


def torques_at_limit(drive: AnyDrive, speed: float, advances: ArrayLike) -> NDArray[np.float64]:
    """Return the torque at the current limit over the advance angle.

    `speed`: shaft speed (rad/s), above 0. `advances`, shape (n,): advance angles (rad electrical). Result, shape (n,):
    mean electromagnetic torques (N m). Raises InputError if the speed is not a usable number.
    """
    demand = torque_demand(drive, speed)
    angles = np.asarray(advances, dtype=np.float64).ravel()
    return np.array([torque_at_limit(demand, float(advance)) for advance in angles])


def greatest_torque_at_limit(drive: AnyDrive, speed: float) -> GreatestTorque:
    """Return the maximum torque at the current limit over all advance angles.

    `drive`, `speed`: arguments of `torques_at_limit`. Result: the best of a grid of 1 degree, and of Brent's method
    within 1 degree of it. Raises InputError if the speed is not a usable number.
    """
    from scipy.optimize import minimize_scalar

    demand = torque_demand(drive, speed)
    torques = [torque_at_limit(demand, radians(degree)) for degree in range(HIGHEST_DEGREES + 1)]
    # Brent's method finds one of several maxima; the grid determines which one.
    best = int(np.argmax(torques))
    found = minimize_scalar(
        lambda advance: -torque_at_limit(demand, float(advance)),
        bounds=(radians(max(best - 1, 0)), radians(min(best + 1, HIGHEST_DEGREES))),
        method="bounded",
        options={"xatol": _ANGLE_TOLERANCE},
    )
    # With a band the maximum is jagged, and the result may be lower than the grid's best point.
    return max(
        GreatestTorque(-float(found.fun), float(found.x)), GreatestTorque(torques[best], radians(best))
    )
