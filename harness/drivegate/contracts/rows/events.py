"""The events of a scenario that a row can wait for, and everything else that changes in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from drivegate_cases.requirements.quantities import voltage_scale
from drivegate_cases.scenario.courses import COURSES, profiles_of
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import value_from, value_until
from drivegate_cases.scenario.profile import dwells, released_s
from drivegate_cases.scenario.scenario import Scenario

_PERCENT = 100.0


@dataclass(frozen=True)
class Occurrence:
    """One event of a run."""

    time_s: float
    size_percent: float = 0.0
    """Size of a step in percent of base speed, rated torque or the link's voltage, negative downward."""


def occurrences(scenario: Scenario, event: str) -> tuple[Occurrence, ...]:
    """Return the events of a kind in a scenario, in their order."""
    if event in _STEPS:
        found = [each for course in _STEPS[event] for each in _steps(scenario, course)]
        return tuple(sorted(found, key=lambda each: each.time_s))
    return tuple(Occurrence(time) for time in _times(scenario, event))


_STEPS = {
    "step of reference": ("speed", "torque_reference"),
    "step of speed reference": ("speed",),
    "step of torque reference": ("torque_reference",),
    "step of load": ("load",),
    "step of link": ("supply",),
}
"""By event, the courses whose steps it is."""


def _times(scenario: Scenario, event: str) -> tuple[float, ...]:
    failure, released = scenario.failure, released_s(scenario)
    match event:
        case "start":
            return (0.0,)
        case "failure":
            return () if failure is None else (failure.time_s,)
        case "restart":
            return scenario.restarts_s
        case "release":
            return () if released is None else (released,)
        case "loss of a signal":
            return tuple(sorted(dropout.start_s for dropout in scenario.dropouts))
        case _:
            return tuple(dwell.start for dwell in dwells(scenario) if dwell.start > 0.0)


def follows(scenario: Scenario, reference: str) -> bool:
    """Return True if the controller of a run follows a reference, ``speed`` or ``torque``."""
    held = isinstance(scenario.load, LockedLoad)
    return not held if reference == "speed" else isinstance(scenario.load, DynamometerLoad)


def _steps(scenario: Scenario, course: str) -> Iterator[Occurrence]:
    if course in ("speed", "torque_reference") and not follows(scenario, course.removesuffix("_reference")):
        return
    profile = COURSES[course].profile(scenario)
    for (time, before), (again, after) in pairwise(profile):
        if time == again > 0.0 and before != after:
            yield Occurrence(time, _PERCENT * _share(scenario, course, time, after - before))


def _share(scenario: Scenario, course: str, time: float, change: float) -> float:
    """Return the size of a step over that of the drive's rating."""
    rating = scenario.drive.rating
    if course == "speed":
        return change / rating.base_speed_rpm
    if course == "torque_reference":
        return change / rating.rated_torque_nm
    if course == "supply":
        return 2.0 * change / voltage_scale(scenario.drive)
    speed, load = value_from(COURSES["speed"].profile(scenario), time), scenario.load
    if isinstance(load, LockedLoad):
        return 0.0
    profile = COURSES["load"].profile(scenario)
    before, after = value_until(profile, time), value_from(profile, time)
    if speed == 0.0 and not isinstance(load, VehicleLoad) and load.kind == "constant_power":
        return 0.0
    return (load.torque_at(speed, after) - load.torque_at(speed, before)) / rating.rated_torque_nm


def changes(scenario: Scenario) -> tuple[float, ...]:
    """Return the times at which anything begins to change, which end what an earlier event has begun (s)."""
    return tuple(sorted({time for times in _changes(scenario).values() for time in times}))


def is_alone(scenario: Scenario, event: str, time_s: float) -> bool:
    """Return True if nothing else changes in the control period of an event."""
    own = {event, *_STEPS.get(event, ())}
    others = (times for name, times in _changes(scenario).items() if name not in own)
    half = 0.5 * scenario.control_period_s
    return not any(abs(time - time_s) < half for times in others for time in times)


def _changes(scenario: Scenario) -> dict[str, tuple[float, ...]]:
    """Return when changes begin, by course or event (s)."""
    found = {
        name: tuple(start for (start, before), (_, after) in pairwise(points) if before != after)
        for name, points in profiles_of(scenario).items()
        if len(points) > 1
    }
    found |= {
        event: _times(scenario, event) for event in ("failure", "restart", "release", "loss of a signal")
    }
    return found | {"glitch": tuple(glitch.time_s for glitch in scenario.glitches)}
