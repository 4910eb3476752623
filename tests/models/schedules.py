"""Schedules of runs: what happens outside of drive and controller."""

from __future__ import annotations

from drivegate_cases.scenario.courses import COURSES
from drivegate_models.loop.schedule import Conditions, Course, Schedule, steady


def schedule_of(speed: float | Course, supply: float | Course, **others: Course) -> Schedule:
    """Return a schedule with the nominal value of every quantity that is not given, in the units of the plant."""
    given = {"speed": _course(speed), "supply": _course(supply), **others}
    return Conditions(
        *(given.get(name) or steady(COURSES[name].nominal or 0.0) for name in Conditions._fields)
    )


def _course(value: float | Course) -> Course:
    return value if isinstance(value, Course) else steady(value)
