"""A fault that takes a shaft for one whose coupling is broken, since it accelerates as it never has before."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from drivegate_models.compilation.kernels import inlined

# Distances from a new reference, relative to it, beyond which the shaft is on its way to it, and up to which it has
# come to it (1).
_ON_ITS_WAY: Final = 0.1
_ARRIVED: Final = 0.01

WATCHED_SHAFT: Final = np.dtype(
    [
        # 1 once a step has been seen; a speed that lags behind (rad/s), and the greatest distance of the speed from it
        # on the way to a reference (rad/s).
        ("is_watched", np.int64),
        ("lagging_speed", np.float64),
        ("farthest_ahead", np.float64),
        # The reference (rad/s), and 1 until the shaft has come to it.
        ("reference", np.float64),
        ("is_on_its_way", np.int64),
    ],
    align=True,
)
"""What has been seen of a shaft."""


@inlined
def breaks_away(shaft: Any, speed: float, reference: float, factor: float, lag: float) -> bool:
    """Update what has been seen of the shaft, and return True if it leaves its reference faster than it came to one.

    - `shaft`: record of `WATCHED_SHAFT`.
    - `speed`, `reference`: of this step (rad/s).
    - `factor`: acceleration that counts as a broken coupling, relative to the greatest on the way to a reference (1).
    - `lag`: steps over which an acceleration is measured (1).
    """
    if shaft.is_watched == 0:
        shaft.is_watched = 1
        shaft.lagging_speed = speed
    shaft.lagging_speed += (speed - shaft.lagging_speed) / lag
    ahead = abs(speed - shaft.lagging_speed)
    distance = abs(reference - speed)
    if reference != shaft.reference:
        shaft.reference = reference
        shaft.is_on_its_way = 1 if distance > _ON_ITS_WAY * abs(reference) else 0
    elif distance <= _ARRIVED * abs(reference):
        shaft.is_on_its_way = 0
    if shaft.is_on_its_way == 1:
        shaft.farthest_ahead = max(shaft.farthest_ahead, ahead)
        return False
    return bool(ahead > factor * shaft.farthest_ahead > 0.0)
