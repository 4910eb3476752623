"""The external conditions of a run, as piecewise linear functions of time."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

ValueT = TypeVar("ValueT")


class Course(NamedTuple):
    """A piecewise linear function of time; a step is two points at one time."""

    times: NDArray[np.float64]
    """Times of the points, shape (n,), never decreasing (s)."""
    values: NDArray[np.float64]
    """Values at these times, shape (n,), in the unit of the quantity."""


class Conditions(NamedTuple, Generic[ValueT]):
    """The external conditions of a run: their values in one control period, or the course of each."""

    speed: ValueT
    """Speed reference of the shaft (rad/s)."""
    load: ValueT
    """Load factor (1), or a vehicle's grade (1)."""
    supply: ValueT
    """Mean voltage of the half-sources (V)."""
    imbalance: ValueT
    """Share by which the upper half-source is above it, and the lower below (1)."""
    resistance: ValueT
    """Factor on the winding resistance (1)."""
    emf_constant: ValueT
    """Factor on the EMF constant (1)."""
    inertia: ValueT
    """Factor on the inertia of rotor and load (1)."""
    friction: ValueT
    """Torque that is added to the friction of the shaft (N m)."""


Schedule: TypeAlias = Conditions[Course]
"""The external conditions of a run over time."""


def steady(value: float) -> Course:
    """Return the course of a quantity that has the same value, in its own unit, at all times."""
    return Course(np.zeros(1), np.full(1, float(value)))


@inlined
def follow(course: Course, positions: NDArray[np.int64], index: int, time: float) -> float:
    """Return a course's value at a time; at a step, the value after it.

    `positions`: index of the point before the last time, for each course; updated. `index`: index of this course in
    `positions`. `time`: time, not earlier than in the last call (s). Result: the value, in the unit of the quantity;
    constant after the last point.
    """
    times = course.times
    values = course.values
    position = positions[index]
    while position + 1 < times.size and times[position + 1] <= time:
        position += 1
    positions[index] = position
    if position + 1 >= times.size:
        return float(values[times.size - 1])
    span = times[position + 1] - times[position]
    share = (time - times[position]) / span
    return float(values[position] + share * (values[position + 1] - values[position]))


@inlined
def conditions_at(schedule: Schedule, positions: NDArray[np.int64], time: float) -> Conditions[float]:
    """Return the external conditions at a time; at a step, the values after it.

    `positions`, shape (n,): index of the point before the last time, for each course; updated. `time`: time, not
    earlier than in the last call (s).
    """
    return Conditions(
        follow(schedule.speed, positions, 0, time),
        follow(schedule.load, positions, 1, time),
        follow(schedule.supply, positions, 2, time),
        follow(schedule.imbalance, positions, 3, time),
        follow(schedule.resistance, positions, 4, time),
        follow(schedule.emf_constant, positions, 5, time),
        follow(schedule.inertia, positions, 6, time),
        follow(schedule.friction, positions, 7, time),
    )
