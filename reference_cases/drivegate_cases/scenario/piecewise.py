"""Piecewise linear profiles over time: a list of [time, value], where two points at one time are a step.

The value before the first point is the first one's, after the last point the last one's; at a step itself the
later value already holds. People may also write a number, which is a constant, or a table with `steps`, each of which
lasts until the next.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field

from drivegate_cases.documents.document import Section

ProfilePoint = tuple[float, float]
_POINTS_OF_A_STEP = 2
_WRITTEN = (
    "must be a number, a list of [time in seconds, value], or a table of steps such as "
    "{steps = [[0.0, 1.0], [0.5, 2.0]]}"
)


class Steps(Section):
    """A course that jumps: each value lasts until the next."""

    steps: tuple[ProfilePoint, ...] = Field(description="list of [time in seconds, value from then on]")


def as_profile(value: Any) -> Any:
    """Write a constant or a table of steps as points; anything else is left to the rules of a profile."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return ((0.0, value),)
    if isinstance(value, Mapping):
        return _stepped(value)
    if isinstance(value, tuple | list):
        return value
    raise ValueError(_WRITTEN)


def _stepped(table: Mapping[str, Any]) -> Any:
    steps = table.get("steps")
    if set(table) != {"steps"} or not isinstance(steps, tuple | list) or not steps:
        raise ValueError(_WRITTEN)
    if not all(isinstance(step, tuple | list) and len(step) == _POINTS_OF_A_STEP for step in steps):
        raise ValueError("must have steps of two numbers each, [time in seconds, value from then on]")
    jumps = [((after[0], before[1]), tuple(after)) for before, after in pairwise(steps)]
    repeated = [after for before, after in pairwise(steps) if after[0] == before[0]]
    if repeated:
        raise ValueError(f"must have steps at different times, but has two at {repeated[0][0]} s")
    return (tuple(steps[0]), *(point for jump in jumps for point in jump))


_Points: TypeAlias = tuple[ProfilePoint, ...]
WRITTEN = BeforeValidator(as_profile, json_schema_input_type=float | Steps | _Points)
"""The ways in which people may write a profile."""
Profile = Annotated[_Points, WRITTEN]


def check_times(points: Profile) -> Profile:
    """Check that the times of a profile start at 0 and never go back."""
    times = [time for time, _ in points]
    if not times or times[0] != 0.0:
        raise ValueError("must have its first point at time 0")
    backward = [later for earlier, later in pairwise(times) if later < earlier]
    if backward:
        raise ValueError(f"must have times that never decrease, which the point at {backward[0]} s does")
    crowded = [time for time in times if times.count(time) > _POINTS_OF_A_STEP]
    if crowded:
        raise ValueError(
            f"must have at most two points at one time, which are a step, but has more at {crowded[0]} s"
        )
    return points


def values_within(least: float, greatest: float, requirement: str) -> AfterValidator:
    """Make the rule that a profile's values are in a range, which is `requirement` in words, and its times in order."""

    def check(points: Profile) -> Profile:
        if not all(least <= value <= greatest for _, value in points):
            raise ValueError(requirement)
        return check_times(points)

    return AfterValidator(check)


def value_from(points: Profile, time: float) -> float:
    """Value of a profile at a time and just after it."""
    return _interpolated(points, time, bisect_right([at for at, _ in points], time))


def value_until(points: Profile, time: float) -> float:
    """Value of a profile just before a time."""
    return _interpolated(points, time, bisect_left([at for at, _ in points], time))


def breakpoints(profiles: Sequence[Profile], end: float) -> list[float]:
    """Merge the times at which any of several profiles has a point."""
    times = {time for points in profiles for time, _ in points}
    return sorted(time for time in times | {0.0, end} if 0.0 <= time <= end)


def _interpolated(points: Profile, time: float, following: int) -> float:
    """Interpolate between the point at index `following` and the one ahead of it, at the ends hold."""
    if following == 0:
        return points[0][1]
    if following == len(points):
        return points[-1][1]
    (earlier, low), (later, high) = points[following - 1], points[following]
    if low == high or time == earlier:
        return low
    if time == later:
        return high
    return low + (high - low) * ((time - earlier) / (later - earlier))
