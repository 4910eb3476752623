"""Searches over the advance angle: the feasible edge, and the least cost of a torque.

The angle runs from 0 to 90 degrees, the paper's range ("Constant Power Operation"). The time goes into the
compiled kernels, which each call runs many times; only the choice of the next angle is made here.
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
# A search needs the order of the costs only; its answer is located anew, to `CURRENT_TOLERANCE`. Over the limit; a
# finer one changes the least current sum of drawn points by less than 1e-4 of it, since a band makes it jump.
_SEARCH_TOLERANCE = 5e-5
# At light load the current sum has several minima, which the coarse grid may rank wrongly.
_VALLEYS = 2
# A valley this much above the least found is not worth a closer look.
_HOPELESS = 1.05
# Step of a look ahead at the coarse grid with the ideal regulator (deg).
_STRIDE = 3
# Half-widths of the band a phase by which it may change the sum of current magnitudes; 0.8 where that is drawn.
_BANDS = 1.0
# How far below a neighbouring angle's reference the scan starts, over the current limit: two of its steps.
_BELOW = 0.02


class TorqueDemand(NamedTuple):
    """A torque demanded of a drive at a speed, with room for the computation."""

    drive: AnyDrive
    """The drive's constants."""
    work: AnyPhases
    """Room for the state of all phases."""
    slices: AnyPhases
    """Room for one phase's state at each shift."""
    speed: float
    """Shaft speed (rad/s)."""
    voltage: float
    """Voltage of each half-source (V)."""
    torque: float
    """Demanded mean electromagnetic torque (N m)."""


class Evaluation(NamedTuple):
    """What a robustly feasible angle costs; infinite where it is not."""

    cost: float
    """Sum of current magnitudes (A) or net input power (W)."""
    advance: float
    """Advance angle (rad electrical)."""
    reference: float
    """Current reference on the side of less torque (A); NaN where not feasible."""


def torque_demand(
    drive: AnyDrive, speed: float, torque: float = 0.0, voltage: float | None = None
) -> TorqueDemand:
    """Return a demand with room for its computation, after a look at the operating point.

    Parameters
    ----------
    drive : AnyDrive
        The drive.
    speed : float
        Shaft speed (rad/s), above 0.
    torque : float
        Demanded mean electromagnetic torque (N m).
    voltage : float, optional
        Voltage of each half-source (V); the drive's nominal one by default.

    Returns
    -------
    TorqueDemand
        The demand.

    Raises
    ------
    InputError
        If speed, torque or voltage is not a usable number.
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

    Parameters
    ----------
    demand : TorqueDemand
        AnyDrive, speed, supply and torque.
    advance : float
        Advance angle (rad electrical).
    tolerance, floor
        As in `drivegate_models.steady.current_search.reference_for_torque`.

    Returns
    -------
    ReferenceSearch
        Out of reach unless the torque at the current limit reaches the demanded one.
    """
    drive, work, slices, speed, voltage, torque = demand
    limit = drive.current_limit
    return reference_for_torque(
        drive, work, slices, speed, voltage, advance, torque, limit, tolerance, floor, True
    )


def torque_at_limit(demand: TorqueDemand, advance: float) -> float:
    """Return the mean torque at the current limit, whatever the demanded one.

    Parameters
    ----------
    demand : TorqueDemand
        AnyDrive, speed and supply.
    advance : float
        Advance angle (rad electrical).

    Returns
    -------
    float
        Mean electromagnetic torque (N m).
    """
    drive, work, slices, speed, voltage, _ = demand
    return mean_state(drive, work, slices, speed, voltage, drive.current_limit, advance).torque


def reaches(demand: TorqueDemand, advance: float, static: bool = False) -> bool:
    """Return whether an advance angle can give a torque.

    Parameters
    ----------
    demand : TorqueDemand
        AnyDrive, speed, supply and torque.
    advance : float
        Advance angle (rad electrical).
    static : bool
        Whether any current reference up to the limit will do, not only the limit itself.

    Returns
    -------
    bool
        Whether it reaches the torque.
    """
    drive, work, slices, speed, voltage, torque = demand
    if torque_at_limit(demand, advance) >= torque:
        return True
    # One steady state decides on robust feasibility; static feasibility is a search over the references.
    if not static:
        return False
    limit = drive.current_limit
    least = least_conceivable(drive, torque)
    most, _ = greatest_torque(drive, work, slices, speed, voltage, advance, limit, least)
    return most >= torque


def _edge_between(demand: TorqueDemand, outside: float, inside: float, static: bool = False) -> float:
    """Return the edge between an infeasible and a feasible angle, in either order, on its feasible side."""
    while abs(inside - outside) > EDGE_TOLERANCE:
        middle = 0.5 * (outside + inside)
        if reaches(demand, middle, static):
            inside = middle
        else:
            outside = middle
    return inside


def smallest_feasible(demand: TorqueDemand, static: bool = False) -> float:
    """Return the smallest advance angle that can give a torque, from a scan in steps of 1 degree.

    Parameters
    ----------
    demand : TorqueDemand
        AnyDrive, speed, supply and torque.
    static : bool
        As in `reaches`.

    Returns
    -------
    float
        The edge (rad electrical), 0 where no advance is needed; NaN if there is none up to 90 degrees.
    """
    # Too much advance loses the torque again, so bisection alone could miss the feasible angles.
    for degrees in range(_DEGREES + 1):
        inside = radians(degrees)
        if reaches(demand, inside, static):
            return _edge_between(demand, radians(degrees - 1), inside, static) if degrees else 0.0
    return nan


def _evaluated(demand: TorqueDemand, by_power: bool, advance: float, nearby: float) -> Evaluation:
    """Return the cost of an angle; the scan starts just below a reference nearby, if that is not NaN."""
    # NaN, which alone differs from itself, stands for no feasible neighbour.
    limit = demand.drive.current_limit
    floor = nearby - _BELOW * limit if nearby == nearby else 0.0
    found = search_reference(demand, advance, _SEARCH_TOLERANCE * limit, floor)
    if found.feasibility != ROBUST:
        return Evaluation(inf, advance, nan)
    return Evaluation(found.input_power if by_power else found.current_sum, advance, found.low)


def _golden(demand: TorqueDemand, by_power: bool, low: float, high: float, nearby: float) -> Evaluation:
    """Return the least cost between two angles, by golden section."""
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


def _finest(demand: TorqueDemand, by_power: bool, valley: Evaluation) -> Evaluation:
    """Return the least cost within 1 degree of a valley of the coarse grid.

    A grid of 0.1 degree, then the edges beside its best point, then golden section between them.
    """
    step = radians(1.0) / _FINE_PARTS
    angles: Iterable[float] = (valley.advance + k * step for k in range(-_FINE_PARTS, _FINE_PARTS + 1))
    inside = [advance for advance in angles if 0.0 <= advance <= _HIGHEST]
    best = min(_evaluated(demand, by_power, advance, valley.reference) for advance in inside)
    # At constant power the least lies on the feasible edge, which golden section never reaches.
    ends = []
    for end in (max(best.advance - step, 0.0), min(best.advance + step, _HIGHEST)):
        feasible = reaches(demand, end)
        ends.append(end if feasible else _edge_between(demand, end, best.advance))
    candidates = [_evaluated(demand, by_power, end, valley.reference) for end in ends]
    return min(best, *candidates, _golden(demand, by_power, ends[0], ends[1], valley.reference))


def promising_angles(demand: TorqueDemand) -> list[int]:
    """Return the angles beside which the sum of current magnitudes may be least.

    Parameters
    ----------
    demand : TorqueDemand
        Drive, speed, supply and torque.

    Returns
    -------
    list of int
        Electrical degrees in ascending order, from a grid of 3 degrees with the ideal regulator, whose steady states
        are found many times as fast as those with a band: at the same torque, the band changes the current of each
        phase by its half-width at most. From 0 to 90 where the ideal regulator reaches the torque nowhere.
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
    # An angle that the coarse grid passes over may be as good as the better one beside it.
    return [
        angle for angle in every if not promising or min(abs(angle - near) for near in promising) < _STRIDE
    ]


def least_cost(demand: TorqueDemand, by_power: bool) -> float:
    """Return the robustly feasible advance angle at which a torque costs least.

    Parameters
    ----------
    demand : TorqueDemand
        AnyDrive, speed, supply and torque.
    by_power : bool
        Whether the net input power is to be least, instead of the sum of current magnitudes.

    Returns
    -------
    float
        The angle (rad electrical), from a grid of 1 degree over the promising angles, the two lowest valleys of it on a
        grid of 0.1 degree, and golden section with the feasible edges; NaN if no angle is robustly feasible.
    """
    # Of the power the ideal regulator tells less: with a band, each switching costs energy.
    is_foretold = demand.drive.hysteresis_band > 0.0 and not by_power
    nearby = nan
    grid = [Evaluation(inf, radians(degrees), nan) for degrees in range(_DEGREES + 1)]
    for degrees in promising_angles(demand) if is_foretold else range(_DEGREES + 1):
        grid[degrees] = _evaluated(demand, by_power, radians(degrees), nearby)
        # Neighbouring angles need much the same current, so each scan starts just below the last result.
        nearby = grid[degrees].reference
    # Beyond the ends, and where nothing is promising, cost is infinite, as where infeasible: a least on an edge is a
    # valley, too.
    costs = [inf, *(point.cost for point in grid), inf]
    valleys = sorted(
        point for k, point in enumerate(grid) if point.cost < inf and costs[k] >= point.cost <= costs[k + 2]
    )
    best = Evaluation(inf, nan, nan)
    for valley in valleys[:_VALLEYS]:
        if valley.cost <= _HOPELESS * best.cost:
            best = min(best, _finest(demand, by_power, valley))
    return best.advance
