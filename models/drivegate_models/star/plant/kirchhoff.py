"""Where the neutral is: Kirchhoff's law as the balance of distances to intervals.

With c = e + R i, a phase on a tread of its staircase wants the neutral at the point v - c; one at a level is content
in the interval between those points of both treads. L di/dt is the signed distance from the neutral to the point
or interval. The currents go on summing to zero where the distances do, which is the root of a falling, piecewise
linear function. The slope of the neutral's voltage solves the same equation one derivative higher.
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
    """Return the point from which the signed distances to all intervals sum to zero.

    Parameters
    ----------
    lows, highs : ndarray, shape (m,)
        Ends of the intervals, not all infinite.

    Returns
    -------
    float
        The point; the middle of what all intervals share, if they do.
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
    # All intervals share what lies between, where nothing pulls.
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
