"""What a drive can do at all: the rules for scenarios that a candidate may fairly be judged on.

There is no braking, since a current reference is never negative: a reference may fall no faster than the
shaft coasts. Below base speed there is no advance, so that a load there must be within what an angle of zero gives,
also where the reference rises through base speed; nor may a step of a load that needs an angle, or a restart under it,
throw the shaft there before any controller can answer. And at every operating point some advance angle must give the
torque; of a load of constant power, also at the speed to which the shaft sags while that load comes on. Nor may the
line of initial angles lie beyond the angles that give it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.advance import advance_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import mean_time
from drivegate_cases.drive.plant import NOMINAL, Scales
from drivegate_cases.scenario.courses import friction_since, profiles_of
from drivegate_cases.scenario.load import ConstantPowerLoad, LockedLoad
from drivegate_cases.scenario.piecewise import Profile, breakpoints, value_from, value_until
from drivegate_cases.scenario.profile import Dwell, dwell_of, dwell_torque
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import HallSensors
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady.oracle import AdvanceLine, feasible_edge
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.steady.torque_limit import torques_at_limit
from drivegate_models.units import RADIANS_PER_RPM

_MOST_PERIODS = 12
"""Control periods in an electrical cycle up to which their number matters: two from one edge to the next (1)."""
REACTION_S = 0.02
"""Time after a step of the load in which no controller can be required to have the torque (s)."""
COASTING_SHARE = 0.5
"""Greatest rate at which a loaded speed reference falls, over the rate at which the load alone slows the shaft (1)."""
UNLOADED_COASTING_SHARE = 0.9
"""The same without a load, over the rate at which the drive's own drag slows the shaft (1)."""
SLOWEST_SHARE = 0.1
"""Least rate at which an unloaded reference falls, over the wanted one (1)."""
SPEED_RESERVE = 0.1
"""Sag of the speed from which a plant that is not nominal must be able to recover under constant power (1)."""
LEAST_SAG = 0.9
"""Least sag of a controller on the nominal plant, over the greatest: measured, as `_sag` says (1)."""
_ROUNDING = 1e-6
_KEPT_DRIVES = 1_000
_KEPT_POINTS = 20_000


class _Stretch(NamedTuple):
    """A straight piece of all profiles, with the conditions at its two ends; a step is one of no length."""

    duration: float
    first: Dwell
    last: Dwell


def is_feasible(scenario: Scenario) -> bool:
    """Return True if the plant can give what a scenario requires wherever it goes, at some angle.

    Every corner of the profiles counts, however short the time spent there; a rising speed reference requires
    the torque that accelerates too. Unequal halves of the supply count as both the weaker one.
    """
    return all(_reaches(scenario, corner, accelerating) for corner, accelerating in _demands(scenario))


def coasts(scenario: Scenario) -> bool:
    """Return True if the speed reference never falls faster than the shaft does by itself."""
    inertia = scenario.nameplate().inertia
    for stretch in _stretches(scenario):
        fall = (stretch.first.speed_rpm - stretch.last.speed_rpm) * RADIANS_PER_RPM
        if fall <= 0.0:
            continue
        if stretch.duration == 0.0:
            return False
        # What slows the shaft while no phase carries current (N m): the load, and the drive's own drag.
        drag = min(
            dwell_torque(scenario, end)
            + _own_drag(_drive(scenario.drive, end.scales), end.speed_rpm * RADIANS_PER_RPM)
            for end in (stretch.first, stretch.last)
        )
        if fall * inertia > drag * stretch.duration * (1.0 + _ROUNDING):
            return False
    return True


def is_driven_without_advance(scenario: Scenario) -> bool:
    """Return True if an angle of zero gives the torque wherever the reference is, or rises from, below base speed."""
    base = scenario.drive.rating.base_speed_rpm
    return all(
        _reaches(scenario, conditions, accelerating, without_advance=True)
        for conditions, accelerating in _demands(scenario)
        if conditions.speed_rpm < base
    )


def withstands_steps(scenario: Scenario) -> bool:
    """Return True if no load that comes at once takes the shaft below base speed before a controller can answer.

    To a controller that is restarted the whole load comes at once.
    """
    steps = [(stretch.first, stretch.last) for stretch in _stretches(scenario) if stretch.duration == 0.0]
    added = [(first, _torque_added(scenario, first, last)) for first, last in steps]
    for time in scenario.restarts_s:
        running = _conditions(scenario, profiles_of(scenario), time, value_from)
        added.append((running, dwell_torque(scenario, running)))
    return all(_stays_fast(scenario, conditions, torque) for conditions, torque in added)


def _torque_added(scenario: Scenario, first: Dwell, last: Dwell) -> float:
    friction = friction_since(first.scales, last.scales)
    return dwell_torque(scenario, last) - dwell_torque(scenario, first) + friction


def _stays_fast(scenario: Scenario, conditions: Dwell, torque: float) -> bool:
    """Return True if a torque that nothing answers for a moment leaves the shaft above base speed."""
    base = scenario.drive.rating.base_speed_rpm * RADIANS_PER_RPM
    speed = conditions.speed_rpm * RADIANS_PER_RPM
    return speed <= base or speed - torque * REACTION_S / scenario.nameplate().inertia > base


def is_fair(scenario: Scenario) -> bool:
    return unfair_because(scenario) is None


def unfair_because(scenario: Scenario) -> str | None:
    if scenario.initial_speed_rpm != scenario.speed_rpm[0][1]:
        return "it does not start at its speed reference"
    if not is_driven_without_advance(scenario):
        return "it requires a load below base speed that no controller can drive without advance"
    if not withstands_steps(scenario):
        return "a step of the load, or a restart, throws the shaft below base speed before a controller can answer"
    if not coasts(scenario):
        return "its speed reference falls faster than the shaft coasts, and there is no braking"
    if not is_feasible(scenario):
        return (
            "at one of its operating points no advance angle gives the torque, or not the one to begin with"
        )
    if beats_with_edges(scenario):
        return "at one of its speeds Hall edges and control periods run almost in step, which moves the current sum"
    return None


def _stretches(scenario: Scenario) -> Iterator[_Stretch]:
    """Cut a run at every corner of its profiles; steps come as pieces of no length.

    A run with a locked shaft, of which nothing is demanded, has none.
    """
    if isinstance(scenario.load, LockedLoad):
        return
    # What accelerates a shaft is judged by the nameplate's inertia, whatever its own is by then.
    profiles = {name: points for name, points in profiles_of(scenario).items() if name != "inertia"}
    times = breakpoints(tuple(profiles.values()), scenario.duration_s)
    before = _conditions(scenario, profiles, times[0], value_from)
    for start, end in pairwise(times):
        first = _conditions(scenario, profiles, start, value_from)
        if first != before:
            yield _Stretch(0.0, before, first)
        before = _conditions(scenario, profiles, end, value_until)
        yield _Stretch(end - start, first, before)


def _conditions(
    scenario: Scenario,
    profiles: Mapping[str, Profile],
    time: float,
    value_at: Callable[[Profile, float], float],
) -> Dwell:
    # The time itself is no condition.
    return dwell_of(scenario, {name: value_at(points, time) for name, points in profiles.items()})


def _demands(scenario: Scenario) -> Iterator[tuple[Dwell, float]]:
    """Give each corner's conditions with the torque that accelerates the shaft there (N m)."""
    inertia = scenario.nameplate().inertia
    step_acceleration = scale_of(scenario.drive).step_acceleration_s
    for stretch in _stretches(scenario):
        rise = (stretch.last.speed_rpm - stretch.first.speed_rpm) * RADIANS_PER_RPM
        accelerating = inertia * max(rise, 0.0) / (stretch.duration or step_acceleration)
        yield stretch.first, accelerating
        yield stretch.last, accelerating
        base = scenario.drive.rating.base_speed_rpm
        if stretch.first.speed_rpm < base <= stretch.last.speed_rpm:
            # The heaviest on the way up is where the advance is about to begin.
            below = math.nextafter(base, 0.0)
            yield replace(stretch.first, speed_rpm=below), accelerating
            yield replace(stretch.last, speed_rpm=below), accelerating


def _reaches(
    scenario: Scenario, conditions: Dwell, accelerating: float, *, without_advance: bool = False
) -> bool:
    load = dwell_torque(scenario, conditions)
    speed = conditions.speed_rpm * RADIANS_PER_RPM
    scales = conditions.scales
    if load == 0.0 == friction_since(scenario.scales, scales) or speed == 0.0:
        return True
    drive = _drive(scenario.drive, scales)
    held = load + _own_drag(drive, speed)
    if held < 0.0:
        # A vehicle that runs downhill by itself would have to be braked.
        return False
    voltage = conditions.supply_v * (1.0 - abs(conditions.imbalance))
    edge = _edge(scenario.drive, scales, speed, held + accelerating, voltage)
    if not math.isfinite(edge) or (without_advance and edge > 0.0):
        return False
    is_nominal = scales == NOMINAL and voltage >= scenario.drive.inverter.supply_voltage_v
    rating = scenario.drive.rating
    # In the range of the line, controllers hold the load by it until their searches have found another angle.
    is_held_by_line = is_nominal and rating.base_speed_rpm <= conditions.speed_rpm <= rating.highest_speed_rpm
    if not isinstance(scenario.load, ConstantPowerLoad):
        return not is_held_by_line or not _is_line_beyond(scenario.drive, speed, held)

    def torque_at(sagged: float) -> float:
        return load / sagged + _own_drag(drive, speed)

    def edge_at(sagged: float) -> float:
        return _edge(scenario.drive, scales, sagged * speed, torque_at(sagged), voltage)

    sag = min(_sag(scenario) / speed, SPEED_RESERVE) if is_nominal else SPEED_RESERVE
    edge = edge_at(1.0 - sag)
    # On the way the shaft may not come below base speed, where there is no advance.
    falls_below = is_held_by_line and (1.0 - sag) * conditions.speed_rpm < rating.base_speed_rpm
    if not math.isfinite(edge) or ((without_advance or falls_below) and edge > 0.0):
        return False
    if not is_nominal or conditions.speed_rpm > rating.highest_speed_rpm:
        return True
    sagged = 1.0 - LEAST_SAG * sag
    if edge_at(sagged) > _first_angle(scenario.drive, sagged * speed):
        return False
    return not is_held_by_line or not _is_line_beyond(scenario.drive, sagged * speed, torque_at(sagged))


def _first_angle(drive: DriveDocument, speed: float) -> float:
    """Return the angle that controllers begin with (rad electrical); a search takes longer than a load to come on."""
    base = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    return AdvanceLine(base, *advance_line(drive)).angle(max(speed, base))


@lru_cache(maxsize=_KEPT_POINTS)
def _is_line_beyond(drive: DriveDocument, speed: float, torque: float) -> bool:
    """Return True if the angle that controllers begin with lies beyond those that give a torque.

    A search that has lost the torque looks for it at more angle, where there is even less.
    """
    plant, first = _drive(drive, NOMINAL), _first_angle(drive, speed)
    lacks = float(torques_at_limit(plant, speed, [first])[0]) < torque
    return lacks and _edge(drive, NOMINAL, speed, torque, plant.half_supply_voltage) <= first


def _sag(scenario: Scenario) -> float:
    """Return how far the speed sags while a load comes on that requires the whole current (rad/s).

    The torque of constant power grows as the speed falls. A shaft stalls where it grows beyond the greatest torque. A
    speed regulator's integral rises to the current limit only while the speed is below its reference. The distance is
    `load_ramp_cost_rpm` for rated torque at the torque per ampere of the nameplate. With advance an ampere has less
    torque, so the regulator pays for the torque that the whole current would have without. The reference controller
    sags by 0.9 to 1.0 times this on the paper's drive and three heavier drawn ones.
    """
    scale, plate = scale_of(scenario.drive), scenario.nameplate()
    torque = plate.conducting_phases * plate.emf_constant * plate.current_limit
    return scale.load_ramp_cost_rpm * RADIANS_PER_RPM * torque / scale.rated_torque_nm


def coasted_rate(drive: DriveDocument, required_rpm_per_s: float) -> float:
    """Return a rate (rpm/s) at which an unloaded shaft slows down near base speed: the required or the coasting one.

    It is 0 where the drive has next to no drag of its own, so that an unloaded shaft does not slow down in good time.
    """
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    drag = _own_drag(_drive(drive, NOMINAL), speed)
    coasting = UNLOADED_COASTING_SHARE * drag / drive.machine.inertia_kg_m2 / RADIANS_PER_RPM
    rate = min(required_rpm_per_s, coasting)
    return rate if rate > SLOWEST_SHARE * required_rpm_per_s else 0.0


def _own_drag(drive: AnyDrive, speed: float) -> float:
    """Friction, and the core loss of the whole EMF, more of which the shaft never has to bear (N m)."""
    core = (
        drive.phases
        * drive.core_loss_conductance
        * (drive.emf_constant * drive.emf_constant)
        * _mean_square(drive)
        * speed
    )
    return friction_torque(drive, speed) + core


def _mean_square(drive: AnyDrive) -> float:
    """Mean square of the back-EMF's shape, exact for its straight pieces (1)."""
    first, last = drive.emf_values[:-1], drive.emf_values[1:]
    pieces = (first * first + first * last + last * last) / 3.0
    return float(np.sum(pieces * np.diff(drive.emf_angles)) / (drive.emf_angles[-1] - drive.emf_angles[0]))


@lru_cache(maxsize=_KEPT_DRIVES)
def _drive(drive: DriveDocument, scales: Scales) -> AnyDrive:
    return drive.plant(scales)


@lru_cache(maxsize=_KEPT_POINTS)
def _edge(drive: DriveDocument, scales: Scales, speed: float, torque: float, voltage: float) -> float:
    """Find the smallest angle that gives a torque; NaN where none does."""
    return feasible_edge(_drive(drive, scales), speed, torque, voltage)


def beats_with_edges(scenario: Scenario) -> bool:
    """Return True if Hall edges fall on nearly the same instants of a control period, cycle after cycle, at some speed.

    The instants at which the edges are seen then drift so slowly that the commutation they give moves for longer than
    the means last by which convergence is judged: Σ|i| moves by 1 % at an angle that no controller has changed.
    """
    if not isinstance(scenario.sensors, HallSensors):
        return False
    rate = 1.0 / scenario.control_period_s
    slowest = 1.0 / mean_time(scenario.drive)
    for start, end in pairwise(breakpoints((scenario.speed_rpm,), scenario.duration_s)):
        speed = value_from(scenario.speed_rpm, start)
        frequency = scenario.drive.machine.pole_pairs * speed / 60.0
        if frequency == 0.0 or value_until(scenario.speed_rpm, end) != speed:
            continue
        periods = round(rate / frequency)
        if periods <= _MOST_PERIODS and abs(periods * frequency - rate) < slowest:
            return True
    return False
