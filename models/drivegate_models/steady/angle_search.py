"""Searches over the advance angle: the feasible edge, and the minimum cost of a torque.

The angle ranges from 0 to 90 degrees, as in the paper ("Constant Power Operation"). Most of the time is spent in the
compiled kernels, which each call runs many times. This module only chooses the next angle.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, isfinite, nan, pi, radians
from typing import NamedTuple

from drivegate_models.errors import InputError
from drivegate_models.steady.current_search import (
    CURRENT_TOLERANCE,
    ROBUST,
    ReferenceSearch,
    greatest_torque,
    mean_state,
    reference_for_torque,
)
from drivegate_models.steady.plant import AnyDrive, AnyPhases, least_conceivable, make_phases

EDGE_TOLERANCE: float = radians(1e-4)
"""Width to which a feasible edge is located (rad)."""

_DEGREES = 90
_HIGHEST = 0.5 * pi
_FINE_PARTS = 10
_GOLDEN = 0.6180339887498949
_ANGLE_TOLERANCE = radians(1e-3)
# Tolerance of references during a search, relative to the current limit. A search needs only the order of the costs;
# its result is located again, to `CURRENT_TOLERANCE`. A finer tolerance changes the minimum current sum of drawn
# points by less than 1e-4 of it, because a band makes it jump.
_SEARCH_TOLERANCE = 5e-5
# At light load the current sum has several minima, which the coarse grid may rank wrongly.
_VALLEYS = 2
# A valley higher than this multiple of the minimum found is not searched further.
_HOPELESS = 1.05
# Step of the preliminary grid with the ideal regulator (deg).
_STRIDE = 3
# Maximum change of the sum of current magnitudes by the band, in half-widths per phase; 0.8 in drawn drives.
_BANDS = 1.0
# The scan starts this far below a neighbouring angle's reference, relative to the current limit: two of its steps.
_BELOW = 0.02


class TorqueDemand(NamedTuple):
    """A demanded torque of a drive at a speed, with work space."""

    drive: AnyDrive
    work: AnyPhases
    """Work space for the state of all phases."""
    slices: AnyPhases
    """Work space for one phase's state at each shift."""
    speed: float
    """Shaft speed (rad/s)."""
    voltage: float
    """Voltage of each half-source (V)."""
    torque: float
    """Demanded mean electromagnetic torque (N m)."""


class Evaluation(NamedTuple):
    """Cost of an angle; infinite if it is not robustly feasible."""

    cost: float
    """Sum of current magnitudes (A) or net input power (W)."""
    advance: float
    """Advance angle (rad electrical)."""
    reference: float
    """Current reference on the side of less torque (A); NaN if not feasible."""


def torque_demand(
    drive: AnyDrive, speed: float, torque: float = 0.0, voltage: float | None = None
) -> TorqueDemand:
    """Return a demand with its work space, after a check of the operating point.

    `speed`: shaft speed (rad/s), above 0. `torque`: demanded mean electromagnetic torque (N m). `voltage`: voltage of
    each half-source (V); the drive's nominal one by default. Result: with work space for means, but not for segments.
    Raises InputError if speed, torque or voltage is not a usable number.
    """
    if not (isfinite(speed) and speed > 0.0):
        raise InputError(f"the speed is {speed:g} rad/s; a steady state needs a finite speed above 0")
    if not isfinite(torque):
        raise InputError(f"the demanded torque is {torque:g} N m; it must be finite")
    supply = drive.half_supply_voltage if voltage is None else voltage
    if not (isfinite(supply) and supply > 0.0):
        raise InputError(f"the half-supply voltage is {supply:g} V; it must be finite and above 0")
    return TorqueDemand(
        drive, make_phases(drive), make_phases(drive), float(speed), float(supply), float(torque)
    )


def search_reference(
    demand: TorqueDemand, advance: float, tolerance: float = CURRENT_TOLERANCE, floor: float = 0.0
) -> ReferenceSearch:
    """Return the reference and the cost of a torque at one advance angle, if robustly feasible.

    `advance`: advance angle (rad electrical). `tolerance`, `floor`: arguments of
    `drivegate_models.steady.current_search.reference_for_torque` (A). Result: out of reach unless the torque at the
    current limit reaches the demanded one.
    """
    drive, work, slices, speed, voltage, torque = demand
    limit = drive.current_limit
    return reference_for_torque(
        drive, work, slices, speed, voltage, advance, torque, limit, tolerance, floor, True
    )


def torque_at_limit(demand: TorqueDemand, advance: float) -> float:
    """Return the mean torque at the current limit.

    `demand`: its torque is not used. `advance`: advance angle (rad electrical). Result: mean electromagnetic torque
    (N m).
    """
    drive, work, slices, speed, voltage, _ = demand
    return mean_state(drive, work, slices, speed, voltage, drive.current_limit, advance).torque


def reaches(demand: TorqueDemand, advance: float, static: bool = False) -> bool:
    """Return True if a torque can be produced at an advance angle.

    `advance`: advance angle (rad electrical). `static`: true to allow any current reference up to the limit, not only
    the limit itself. Result: true if the mean torque reaches the demanded one.
    """
    drive, work, slices, speed, voltage, torque = demand
    if torque_at_limit(demand, advance) >= torque:
        return True
    # One steady state determines robust feasibility; static feasibility needs a search over the references.
    if not static:
        return False
    limit = drive.current_limit
    least = least_conceivable(drive, torque)
    most, _ = greatest_torque(drive, work, slices, speed, voltage, advance, limit, least)
    return most >= torque


def _edge_between(demand: TorqueDemand, outside: float, inside: float, static: bool = False) -> float:
    """Return the feasible side of the edge between an infeasible and a feasible angle, in either order (rad)."""
    while abs(inside - outside) > EDGE_TOLERANCE:
        middle = 0.5 * (outside + inside)
        if reaches(demand, middle, static):
            inside = middle
        else:
            outside = middle
    return inside


def smallest_feasible(demand: TorqueDemand, static: bool = False) -> float:
    """Return the smallest advance angle that can produce a torque, from a scan in steps of 1 degree.

    `static`: true to allow any current reference up to the limit, as in `reaches`. Result: the edge (rad electrical),
    0 if no advance is needed; NaN if there is none up to 90 degrees.
    """
    # Too much advance loses the torque again, so bisection alone could miss the feasible angles.
    for degrees in range(_DEGREES + 1):
        inside = radians(degrees)
        if reaches(demand, inside, static):
            return _edge_between(demand, radians(degrees - 1), inside, static) if degrees else 0.0
    return nan


def _evaluated(demand: TorqueDemand, by_power: bool, advance: float, nearby: float) -> Evaluation:
    """Return the cost of an angle; the scan starts just below the reference of a neighbour, unless that is NaN."""
    # NaN, which differs from itself, indicates no feasible neighbour.
    limit = demand.drive.current_limit
    floor = nearby - _BELOW * limit if nearby == nearby else 0.0
    found = search_reference(demand, advance, _SEARCH_TOLERANCE * limit, floor)
    if found.feasibility != ROBUST:
        return Evaluation(inf, advance, nan)
    return Evaluation(found.input_power if by_power else found.current_sum, advance, found.low)


def _golden(demand: TorqueDemand, by_power: bool, low: float, high: float, nearby: float) -> Evaluation:
    """Return the minimum cost between two angles, by golden section."""
    left = _evaluated(demand, by_power, high - _GOLDEN * (high - low), nearby)
    right = _evaluated(demand, by_power, low + _GOLDEN * (high - low), nearby)
    while high - low > _ANGLE_TOLERANCE:
        if left.cost <= right.cost:
            high, right = right.advance, left
            left = _evaluated(demand, by_power, high - _GOLDEN * (high - low), nearby)
        else:
            low, left = left.advance, right
            right = _evaluated(demand, by_power, low + _GOLDEN * (high - low), nearby)
    return min(left, right)


def _refined(demand: TorqueDemand, by_power: bool, valley: Evaluation) -> Evaluation:
    """Return the minimum cost within 1 degree of a valley of the coarse grid.

    The search uses a grid of 0.1 degree, then the edges next to its best point, then golden section between them.
    """
    step = radians(1.0) / _FINE_PARTS
    angles: Iterable[float] = (valley.advance + k * step for k in range(-_FINE_PARTS, _FINE_PARTS + 1))
    inside = [advance for advance in angles if 0.0 <= advance <= _HIGHEST]
    best = min(_evaluated(demand, by_power, advance, valley.reference) for advance in inside)
    # At constant power the minimum is on the feasible edge, which golden section never reaches.
    ends = []
    for end in (max(best.advance - step, 0.0), min(best.advance + step, _HIGHEST)):
        feasible = reaches(demand, end)
        ends.append(end if feasible else _edge_between(demand, end, best.advance))
    candidates = [_evaluated(demand, by_power, end, valley.reference) for end in ends]
    return min(best, *candidates, _golden(demand, by_power, ends[0], ends[1], valley.reference))


def promising_angles(demand: TorqueDemand) -> list[int]:
    """Return the angles near which the sum of current magnitudes may be minimal.

    Result: electrical degrees in ascending order, from a grid of 3 degrees with the ideal regulator. Its steady states
    are found many times faster than those with a band. At the same torque, the band changes the current of each phase
    by at most its half-width. All angles from 0 to 90 if the ideal regulator never reaches the torque.
    """
    ideal = demand._replace(drive=demand.drive._replace(hysteresis_band=0.0))
    coarse = range(0, _DEGREES + 1, _STRIDE)
    costs = []
    nearby = nan
    for degrees in coarse:
        point = _evaluated(ideal, False, radians(degrees), nearby)
        costs.append(point.cost)
        nearby = point.reference
    reserve = _BANDS * demand.drive.phases * demand.drive.hysteresis_band
    highest = _HOPELESS * (min(costs) + reserve) + reserve
    promising = [degrees for degrees, cost in zip(coarse, costs, strict=True) if cost <= highest < inf]
    every = range(_DEGREES + 1)
    # An angle between two points of the coarse grid may be as good as the better one of them.
    return [
        angle for angle in every if not promising or min(abs(angle - near) for near in promising) < _STRIDE
    ]


def least_cost(demand: TorqueDemand, by_power: bool) -> float:
    """Return the robustly feasible advance angle of minimum cost for a torque.

    `by_power`: true to minimize the net input power, False to minimize the sum of current magnitudes. Result: the
    angle (rad electrical), from a grid of 1 degree over the promising angles, its two lowest valleys on a grid of 0.1
    degree, and golden section with the feasible edges; NaN if no angle is robustly feasible.
    """
    # The ideal regulator is a poor estimate of the power: with a band, each switching costs energy.
    has_estimate = demand.drive.hysteresis_band > 0.0 and not by_power
    nearby = nan
    grid = [Evaluation(inf, radians(degrees), nan) for degrees in range(_DEGREES + 1)]
    for degrees in promising_angles(demand) if has_estimate else range(_DEGREES + 1):
        grid[degrees] = _evaluated(demand, by_power, radians(degrees), nearby)
        # Neighbouring angles need similar currents, so each scan starts just below the last result.
        nearby = grid[degrees].reference
    # Beyond the ends, and at angles that are not promising, the cost is infinite, as at infeasible ones: a minimum
    # on an edge is a valley, too.
    costs = [inf, *(point.cost for point in grid), inf]
    valleys = sorted(
        point for k, point in enumerate(grid) if point.cost < inf and costs[k] >= point.cost <= costs[k + 2]
    )
    best = Evaluation(inf, nan, nan)
    for valley in valleys[:_VALLEYS]:
        if valley.cost <= _HOPELESS * best.cost:
            best = min(best, _refined(demand, by_power, valley))
    return best.advance
