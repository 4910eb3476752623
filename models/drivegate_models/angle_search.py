"""Searches over the advance angle: the feasible edge, and the least cost of a torque.

The angle runs from 0 to 90 degrees, the paper's range ("Constant Power Operation"). Only robustly feasible
angles count: those at which the torque at the current limit reaches the wanted one.
"""

from __future__ import annotations

from math import inf, nan, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation import kernel
from drivegate_models.drive import Drive
from drivegate_models.plant import Phases
from drivegate_models.reference_search import (
    CURRENT_TOLERANCE,
    OUT_OF_REACH,
    ROBUST,
    greatest_torque,
    mean_state,
    reference_for_torque,
)

EDGE_TOLERANCE: float = 1e-4 * pi / 180.0
"""Width to which a feasible edge is located (rad)."""

_DEGREE = pi / 180.0
_ANGLES = 91
_FINE_PARTS = 10
_GOLDEN = 0.6180339887498949
_ANGLE_TOLERANCE = 1e-3 * _DEGREE
_SEARCH_TOLERANCE = 1e-5
_VALLEYS = 2


class Cost(NamedTuple):
    """What a torque costs at one advance angle."""

    feasibility: int
    """`ROBUST`, `STATIC` or `OUT_OF_REACH`."""
    reference: float
    """Current reference (A), the time mean of both where the torque is a mix; NaN out of reach."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A); NaN out of reach."""
    input_power: float
    """Net power taken from the supply, core loss and switching included (W); NaN out of reach."""


@kernel
def reaches(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    advance: float,
    torque: float,
    static: bool,
) -> bool:
    """Return whether an advance angle can give a torque.

    Parameters
    ----------
    drive, work, slices, speed, voltage, advance
        As in `drivegate_models.reference_search.mean_state`.
    torque : float
        Wanted mean electromagnetic torque (N m).
    static : bool
        Whether any current reference up to the limit will do, not only the limit itself.

    Returns
    -------
    bool
        Whether it reaches the torque.
    """
    limit = drive.current_limit
    if mean_state(drive, work, slices, speed, voltage, limit, advance).torque >= torque:
        return True
    if not static:
        return False
    most, _ = greatest_torque(drive, work, slices, speed, voltage, advance, limit)
    return most >= torque


@kernel
def _edge_between(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    torque: float,
    static: bool,
    outside: float,
    inside: float,
) -> float:
    """Return the feasible side of the edge between an infeasible and a feasible angle, on either side of it."""
    while abs(inside - outside) > EDGE_TOLERANCE:
        middle = 0.5 * (outside + inside)
        if reaches(drive, work, slices, speed, voltage, middle, torque, static):
            inside = middle
        else:
            outside = middle
    return inside


@kernel
def smallest_feasible(
    drive: Drive, work: Phases, slices: Phases, speed: float, voltage: float, torque: float, static: bool
) -> float:
    """Return the smallest advance angle that can give a torque, from a scan in steps of 1 degree.

    Parameters
    ----------
    drive, work, slices, speed, voltage, torque, static
        As in `reaches`.

    Returns
    -------
    float
        The edge (rad electrical), 0 where no advance is needed; NaN if there is none up to 90 degrees.
    """
    for k in range(_ANGLES):
        inside = k * _DEGREE
        if reaches(drive, work, slices, speed, voltage, inside, torque, static):
            if k == 0:
                return 0.0
            outside = (k - 1) * _DEGREE
            return _edge_between(drive, work, slices, speed, voltage, torque, static, outside, inside)
    return nan


@kernel
def cost_at(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    torque: float,
    advance: float,
    tolerance: float,
) -> Cost:
    """Return what a torque costs at one advance angle.

    Parameters
    ----------
    drive, work, slices, speed, voltage, torque, advance
        As in `reaches`.
    tolerance : float
        Width to which the current reference is located (A).

    Returns
    -------
    Cost
        Means; a mix of two references where the torque jumps across the wanted one.
    """
    found = reference_for_torque(
        drive, work, slices, speed, voltage, advance, torque, drive.current_limit, tolerance
    )
    if found.feasibility == OUT_OF_REACH:
        return Cost(OUT_OF_REACH, nan, nan, nan)
    low = mean_state(drive, work, slices, speed, voltage, found.low, advance)
    if found.share == 0.0:
        return Cost(found.feasibility, found.low, low.current_sum, low.input_power)
    high = mean_state(drive, work, slices, speed, voltage, found.high, advance)
    share = found.share
    return Cost(
        found.feasibility,
        found.low + share * (found.high - found.low),
        low.current_sum + share * (high.current_sum - low.current_sum),
        low.input_power + share * (high.input_power - low.input_power),
    )


@kernel
def _objective(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    torque: float,
    by_power: bool,
    advance: float,
) -> float:
    """Return the quantity to be minimised, infinite where the angle is not robustly feasible."""
    limit = drive.current_limit
    if mean_state(drive, work, slices, speed, voltage, limit, advance).torque < torque:
        return inf
    cost = cost_at(drive, work, slices, speed, voltage, torque, advance, _SEARCH_TOLERANCE)
    if cost.feasibility != ROBUST:
        return inf
    return cost.input_power if by_power else cost.current_sum


@kernel
def _finest(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    torque: float,
    by_power: bool,
    center: float,
) -> tuple[float, float]:
    """Return the angle of least cost within 1 degree of a grid point, and that cost.

    A grid of 0.1 degree, then the edges beside its best point, then golden section between them.
    """
    step = _DEGREE / _FINE_PARTS
    best = center
    least = inf
    for k in range(-_FINE_PARTS, _FINE_PARTS + 1):
        advance = center + k * step
        if 0.0 <= advance <= 0.5 * pi:
            cost = _objective(drive, work, slices, speed, voltage, torque, by_power, advance)
            if cost < least:
                least = cost
                best = advance
    low = max(best - step, 0.0)
    high = min(best + step, 0.5 * pi)
    grid_best = best
    for outer in (low, high):
        edge = outer
        cost = _objective(drive, work, slices, speed, voltage, torque, by_power, outer)
        if cost == inf:
            edge = _edge_between(drive, work, slices, speed, voltage, torque, False, outer, grid_best)
            cost = _objective(drive, work, slices, speed, voltage, torque, by_power, edge)
        if outer == low:
            low = edge
        else:
            high = edge
        if cost < least:
            least = cost
            best = edge
    while high - low > _ANGLE_TOLERANCE:
        left = high - _GOLDEN * (high - low)
        right = low + _GOLDEN * (high - low)
        left_cost = _objective(drive, work, slices, speed, voltage, torque, by_power, left)
        right_cost = _objective(drive, work, slices, speed, voltage, torque, by_power, right)
        if left_cost < least:
            least = left_cost
            best = left
        if right_cost < least:
            least = right_cost
            best = right
        if left_cost <= right_cost:
            high = right
        else:
            low = left
    return best, least


@kernel
def least_cost(
    drive: Drive, work: Phases, slices: Phases, speed: float, voltage: float, torque: float, by_power: bool
) -> tuple[float, Cost]:
    """Return the robustly feasible advance angle at which a torque costs least.

    Parameters
    ----------
    drive, work, slices, speed, voltage, torque
        As in `reaches`.
    by_power : bool
        Whether the net input power is to be least, instead of the sum of current magnitudes.

    Returns
    -------
    advance : float
        The angle (rad electrical); NaN if no angle is robustly feasible.
    cost : Cost
        The cost there.
    """
    costs = np.empty(_ANGLES)
    for k in range(_ANGLES):
        costs[k] = _objective(drive, work, slices, speed, voltage, torque, by_power, k * _DEGREE)
    is_valley = np.isfinite(costs)
    for k in range(_ANGLES):
        if (k > 0 and costs[k - 1] < costs[k]) or (k < _ANGLES - 1 and costs[k + 1] < costs[k]):
            is_valley[k] = False
    best = nan
    least = inf
    for _ in range(_VALLEYS):
        valley = -1
        for k in range(_ANGLES):
            if is_valley[k] and (valley < 0 or costs[k] < costs[valley]):
                valley = k
        if valley < 0:
            break
        is_valley[valley] = False
        advance, cost = _finest(drive, work, slices, speed, voltage, torque, by_power, valley * _DEGREE)
        if cost < least:
            least = cost
            best = advance
    if least == inf:
        return nan, Cost(OUT_OF_REACH, nan, nan, nan)
    return best, cost_at(drive, work, slices, speed, voltage, torque, best, CURRENT_TOLERANCE)


@kernel
def costs_along(
    drive: Drive,
    work: Phases,
    slices: Phases,
    speed: float,
    voltage: float,
    torque: float,
    advances: NDArray[np.float64],
    table: NDArray[np.float64],
) -> None:
    """Fill a table with what a torque costs at each of several advance angles.

    Parameters
    ----------
    drive, work, slices, speed, voltage, torque
        As in `reaches`.
    advances : ndarray, shape (n,)
        Advance angles (rad electrical).
    table : ndarray, shape (n, 3)
        Receives feasibility code, sum of current magnitudes (A) and net input power (W).
    """
    for k in range(advances.size):
        cost = cost_at(drive, work, slices, speed, voltage, torque, advances[k], CURRENT_TOLERANCE)
        table[k, 0] = cost.feasibility
        table[k, 1] = cost.current_sum
        table[k, 2] = cost.input_power
