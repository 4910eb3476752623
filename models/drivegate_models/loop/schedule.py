"""What happens to a run from outside, as piecewise linear functions of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined


class Course(NamedTuple):
    """A piecewise linear function of time; a step is two points at one time."""

    times: NDArray[np.float64]
    """Shape (n,), never decreasing (s)."""
    values: NDArray[np.float64]
    """Shape (n,), in the unit of the quantity."""


class Schedule(NamedTuple):
    """What happens during a run."""

    speed: Course
    """Speed reference (rad/s)."""
    load: Course
    """Load factor (1), or a vehicle's grade (1)."""
    supply: Course
    """Mean voltage of the half-sources (V)."""
    imbalance: Course
    """Share by which the upper half-source is above it, and the lower below (1)."""
    resistance: Course
    """Factor on the winding resistance (1)."""
    emf: Course
    """Factor on the EMF constant (1)."""


class Conditions(NamedTuple):
    """What acts on a drive from outside in one control period."""

    speed_reference: float
    """(rad/s)."""
    load_factor: float
    """Load factor (1), or a vehicle's grade (1)."""
    supply: float
    """Mean voltage of the half-sources (V)."""
    imbalance: float
    """Share by which the upper half-source is above it, and the lower below (1)."""
    resistance_factor: float
    """Factor on the winding resistance (1)."""
    emf_factor: float
    """Factor on the EMF constant (1)."""


def steady(value: float) -> Course:
    """Make the course of a quantity that does not change.

    Parameters
    ----------
    value : float
        The quantity.

    Returns
    -------
    Course
        The same value at all times.
    """
    return Course(np.zeros(1), np.full(1, float(value)))


@inlined
def follow(course: Course, positions: NDArray[np.int64], index: int, time: float) -> float:
    """Return a course's value at a time no earlier than the last one; at a step the one behind it.

    Parameters
    ----------
    course : Course
        What is followed.
    positions : ndarray of int64
        Where each course was found last; updated.
    index : int
        Place of this course among them.
    time : float
        Time (s).

    Returns
    -------
    float
        The value, in the unit of the quantity.
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
def conditions_at(schedule: Schedule, positions: NDArray[np.int64], time: float) -> Conditions:
    """Return what acts at a time no earlier than the last one.

    Parameters
    ----------
    schedule : Schedule
        What happens during the run.
    positions : ndarray of int64, shape (6,)
        Where each course was found last; updated.
    time : float
        Time (s).

    Returns
    -------
    Conditions
        The values; at a step those behind it.
    """
    return Conditions(
        follow(schedule.speed, positions, 0, time),
        follow(schedule.load, positions, 1, time),
        follow(schedule.supply, positions, 2, time),
        follow(schedule.imbalance, positions, 3, time),
        follow(schedule.resistance, positions, 4, time),
        follow(schedule.emf, positions, 5, time),
    )
