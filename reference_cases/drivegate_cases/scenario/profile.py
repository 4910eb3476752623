"""What follows from a scenario's profiles: their layout for compiled code, and where all stand still."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.drive.plant import NOMINAL, Scales
from drivegate_cases.scenario.control_periods import seen_at_s
from drivegate_cases.scenario.courses import profiles_of, with_courses
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad
from drivegate_cases.scenario.piecewise import Profile, breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Dwell:
    """A stretch in which nothing outside of the controller changes."""

    start: float
    end: float
    """Time at which the stretch begins and ends (s)."""
    speed_rpm: float
    load_factor: float
    """Share of the load; 1 for a locked shaft, the grade (%) for a vehicle."""
    supply_v: float
    """Mean voltage of the halves of the supply (V)."""
    imbalance: float = 0.0
    """Share by which the halves differ from it."""
    torque_reference_nm: float | None = None
    """Torque reference (N·m); None where the reference is the speed."""
    scales: Scales = NOMINAL
    """The plant's parameters, with their drift."""

    @property
    def duration(self) -> float:
        return self.end - self.start


def profile_arrays(
    points: Profile, control_period_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lay a profile out for compiled code, its times as the loop sees them."""
    seen = [(seen_at_s(time, control_period_s), value) for time, value in points]
    table = np.array(seen, dtype=np.float64).reshape(-1, 2)
    return np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])


def dwell_of(scenario: Scenario, values: Mapping[str, float], start: float = 0.0, end: float = 0.0) -> Dwell:
    """Return the conditions of a scenario where its courses, by name, have some values."""
    is_torque = isinstance(scenario.load, DynamometerLoad)
    return Dwell(
        start,
        end,
        speed_rpm=values["speed"],
        load_factor=values["load"],
        supply_v=values["supply"],
        imbalance=values["imbalance"],
        torque_reference_nm=values["torque_reference"] if is_torque else None,
        scales=with_courses(scenario.scales, values),
    )


def dwells(scenario: Scenario, *, seen_throughout: bool = False) -> tuple[Dwell, ...]:
    """Find the stretches of a scenario in which reference, load, supply, plant and sensors are all constant.

    A restart of the controller ends one, as an event that is over at once, and so does the release of the shaft. With
    `seen_throughout` so does the loss of a signal, at its end; without, it is in none.
    """
    profiles = profiles_of(scenario)
    # Most stay as they begin, and need no second look.
    begin = {name: points[0][1] for name, points in profiles.items()}
    moving = {name: points for name, points in profiles.items() if len(points) > 1}
    failures = [
        (dropout.end_s if seen_throughout else dropout.start_s, dropout.end_s)
        for dropout in scenario.dropouts
    ]
    failures += [(glitch.time_s, glitch.time_s) for glitch in scenario.glitches]
    failures += [(time, time) for time in scenario.restarts_s]
    if (released := released_s(scenario)) is not None:
        failures.append((released, released))
    # A failure begins at the first of its two points and is over at the second.
    events: tuple[Profile, ...] = tuple(((start, 0.0), (end, 0.0)) for start, end in failures)
    interruptions = {end for _, end in failures}
    found: list[tuple[float, float, dict[str, float]]] = []
    for start, end in pairwise(breakpoints((*moving.values(), *events), scenario.duration_s)):
        constant = {name: value_from(points, start) for name, points in moving.items()}
        if constant != {name: value_until(points, end) for name, points in moving.items()}:
            continue
        if any(failed <= start and end <= back for failed, back in failures):
            continue
        if found and found[-1][1:] == (start, constant) and start not in interruptions:
            found[-1] = (found[-1][0], end, constant)
        else:
            found.append((start, end, constant))
    return tuple(dwell_of(scenario, begin | values, start, end) for start, end, values in found)


def released_s(scenario: Scenario) -> float | None:
    """Return the time from which a dynamometer no longer holds the shaft (s); None where it always does."""
    return scenario.load.released_s if isinstance(scenario.load, DynamometerLoad) else None


def dwell_torque(scenario: Scenario, dwell: Dwell) -> float:
    """Return the torque that the load demands while nothing changes."""
    if isinstance(scenario.load, LockedLoad) or dwell.load_factor == 0.0 == dwell.speed_rpm:
        return 0.0
    return scenario.load.torque_at(dwell.speed_rpm, dwell.load_factor)


def is_after_change(scenario: Scenario, dwell: Dwell) -> bool:
    """Return whether anything has changed before a stretch, or the controller has been restarted."""
    earlier = [other for other in dwells(scenario) if other.start < dwell.start]
    failed = any(dropout.start_s < dwell.start for dropout in scenario.dropouts)
    failed |= any(time <= dwell.start for time in scenario.restarts_s)
    failed |= any(glitch.time_s <= dwell.start for glitch in scenario.glitches)
    return failed or any(dwell_torque(scenario, other) > 0.0 for other in earlier)
