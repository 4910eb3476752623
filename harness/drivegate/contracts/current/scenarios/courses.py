"""The profiles of a scenario as values and their changes, which is how they are made simpler."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario

_LAST: Final = ("resistance", "emf_constant", "imbalance", "supply", "speed", "load")
QUANTITIES: Final = (*(name for name in COURSES if name not in (*_LAST, "torque_reference")), *_LAST)
"""Those of this contract, the ones that a plain run has not got first."""


@dataclass(frozen=True)
class Change:
    """A change of a value, over a time or at once."""

    start: float
    end: float
    """Time at which it begins and is over (s)."""
    value: float
    """Value afterwards."""


@dataclass(frozen=True)
class ProfileCourse:
    """A profile as its first value and its changes."""

    first: float
    changes: tuple[Change, ...]

    @classmethod
    def of(cls, profile: Profile) -> ProfileCourse:
        changes = [
            Change(start, end, after)
            for (start, before), (end, after) in pairwise(profile)
            if before != after
        ]
        return cls(profile[0][1], tuple(changes))

    def profile(self) -> Profile:
        points = [(0.0, self.first)]
        for change in self.changes:
            for point in ((change.start, points[-1][1]), (change.end, change.value)):
                if point != points[-1]:
                    points.append(point)
        return tuple(points)

    def values(self) -> tuple[float, ...]:
        return self.first, *(change.value for change in self.changes)

    def steadier(self) -> Iterator[ProfileCourse]:
        for value in dict.fromkeys(reversed(self.values())):
            yield ProfileCourse(value, ())
        for index, change in enumerate(self.changes):
            others = self.changes[:index] + self.changes[index + 1 :]
            yield ProfileCourse(self.first, others)
            if index == 0:
                yield ProfileCourse(change.value, others)
            else:
                before = replace(self.changes[index - 1], value=change.value)
                yield ProfileCourse(
                    self.first, (*self.changes[: index - 1], before, *self.changes[index + 1 :])
                )

    def mapped(
        self,
        value: Callable[[float], float] = lambda value: value,
        time: Callable[[float], float] = lambda time: time,
    ) -> ProfileCourse:
        changes = (
            Change(time(change.start), time(change.end), value(change.value)) for change in self.changes
        )
        return ProfileCourse(value(self.first), tuple(changes))

    def until(self, end: float) -> ProfileCourse:
        """Leave out what begins at a time or later, or is not over by then."""
        return ProfileCourse(self.first, tuple(c for c in self.changes if c.start < end and c.end <= end))


def course_of(scenario: Scenario, quantity: str) -> ProfileCourse:
    return ProfileCourse.of(COURSES[quantity].profile(scenario))


def fields_of(scenario: Scenario, quantity: str, course: ProfileCourse) -> dict[str, Any]:
    return COURSES[quantity].fields(scenario, course.profile())
