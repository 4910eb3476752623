"""Voltage of the neutral: Kirchhoff's law as the balance of distances to intervals.

With c = e + R i, the current of a phase on a tread of its staircase is constant with the neutral at the point v - c.
At a level it is constant in the interval between those points of both treads. L di/dt is the signed distance from the
neutral to the point or interval. The currents continue to sum to zero if the distances do, which is the root of a
falling, piecewise linear function. The slope of the neutral's voltage solves the same equation for the next
derivative.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined


@inlined
def _pull(lows: NDArray[np.float64], highs: NDArray[np.float64], point: float) -> float:
    """Return the sum of the signed distances from a point to every interval."""
    total = 0.0
    for k in range(lows.size):
        if lows[k] > point:
            total += lows[k] - point
        elif highs[k] < point:
            total += highs[k] - point
    return total


@inlined
def balance(lows: NDArray[np.float64], highs: NDArray[np.float64]) -> float:
    """Return the point whose signed distances to all intervals sum to zero.

    `lows`, `highs`, shape (m,): ends of the intervals (V, or V/s), not all infinite. Result: the point, in the same
    unit; the middle of the intersection of all intervals if it is not empty.
    """
    below = -inf
    above = inf
    for k in range(lows.size):
        for side in range(2):
            bound = lows[k] if side == 0 else highs[k]
            if abs(bound) == inf:
                continue
            pull = _pull(lows, highs, bound)
            if pull >= 0.0:
                below = max(below, bound)
            if pull <= 0.0:
                above = min(above, bound)
    # The intersection of all intervals is in between; the distances are zero there.
    if below >= above:
        return 0.5 * (below + above)
    total = 0.0
    count = 0
    for k in range(lows.size):
        if highs[k] <= below:
            total += highs[k]
            count += 1
        elif lows[k] >= above:
            total += lows[k]
            count += 1
    return total / count
