"""Events that end a stretch: a current reaches a level, or the neutral reaches the end of an interval."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.winding_current import Phis, crossing_time, current_by, phis_at
from drivegate_models.star.plant.neutral import TIE, Neutral
from drivegate_models.star.plant.places import HELD
from drivegate_models.star.plant.regulation import comparator_level
from drivegate_models.star.plant.staircase import Circuit, Staircase, levels_of


class Event(NamedTuple):
    """The first event of a stretch."""

    length: float
    """Time from the stretch's start (s)."""
    phase: int
    """Phase whose current reaches or leaves a level; -1 without an event."""
    other: int
    """Phase whose current leaves its level to the other side at the same instant, or -1."""
    level: float
    """The level that a current reaches (A)."""
    side: int
    """Interval's end that the neutral reaches, 1 upper or -1 lower; 0 if a current reaches a level."""


@inlined
def bound_motion(circuit: Circuit, place: Any) -> None:
    """Set the levels between which the current of a moving phase has no event (A)."""
    floor, ceiling = levels_of(Staircase(place.first, place.second, place.gate), place.tread)
    level, side = comparator_level(circuit, place)
    if side > 0:
        ceiling = min(ceiling, level)
    elif side < 0:
        floor = max(floor, level)
    place.floor = floor
    place.ceiling = ceiling


@inlined
def _current_event(rate: float, place: Any, start: float, length: float, phis: Phis) -> tuple[float, float]:
    """Return the time at which a moving current reaches one of its levels (s), and that level (A)."""
    slope = place.slope
    curvature = place.curvature
    end, end_slope = current_by(start, slope, curvature, length, phis)
    time = inf
    level = 0.0
    if place.ceiling < inf and (slope > 0.0 or end_slope > 0.0 or end >= place.ceiling):
        time = crossing_time(start, slope, curvature, rate, length, end, end_slope, place.ceiling, True)
        level = place.ceiling
    if place.floor > -inf and (slope < 0.0 or end_slope < 0.0 or end <= place.floor):
        falling = crossing_time(start, slope, curvature, rate, length, end, end_slope, place.floor, False)
        if falling < time:
            time = falling
            level = place.floor
    return time, level


@inlined
def _is_mirror_image(place: Any, other: Any) -> bool:
    """Return True if one moving current and its levels are the negatives of another's."""
    return bool(
        place.start == -other.start
        and place.slope == -other.slope
        and place.curvature == -other.curvature
        and place.floor == -other.ceiling
        and place.ceiling == -other.floor
    )


@inlined
def _voltage_event(place: Any, neutral: Neutral) -> tuple[float, int]:
    """Return the time at which the neutral leaves the interval of a held phase (s), and by which end (1 or -1)."""
    # Relative to the interval, which moves with the back-EMF.
    rate = neutral.rate + place.opposed_rate
    if rate > 0.0 and not place.at_high:
        return (place.high - neutral.voltage) / rate, 1
    if rate < 0.0 and not place.at_low:
        return (place.low - neutral.voltage) / rate, -1
    return inf, 0


@inlined
def _bounding(places: NDArray[Any], sign: float, tie: float) -> int:
    """Return the phase whose interval bounds the intersection from now on, from above (1) or below (-1)."""
    bounding = 0
    for k in range(1, places.size):
        one = places[bounding]
        other = places[k]
        ahead = (one.high - other.high) if sign > 0.0 else (other.low - one.low)
        faster = sign * (other.opposed_rate - one.opposed_rate)
        if ahead > tie or (ahead >= -tie and faster > 0.0):
            bounding = k
    return bounding


@inlined
def _separation_event(places: NDArray[Any], tie: float, length: float) -> Event:
    """Return the first event while no phase moves: two phases leave their levels, or others bound the intersection."""
    lowest = _bounding(places, -1.0, tie)
    highest = _bounding(places, 1.0, tie)
    low = places[lowest]
    high = places[highest]
    first = Event(length, -1, -1, 0.0, 0)
    rate = high.opposed_rate - low.opposed_rate
    # Two phases that have just been released together do not separate.
    if rate > 0.0 and not (low.at_low and high.at_high) and lowest != highest:
        time = (high.high - low.low) / rate
        if time < length:
            first = Event(max(time, 0.0), highest, lowest, 0.0, 1)
    for k in range(places.size):
        place = places[k]
        rate = place.opposed_rate - high.opposed_rate
        if rate > 0.0 and tie < place.high - high.high < rate * first.length:
            first = Event((place.high - high.high) / rate, -1, -1, 0.0, 0)
        rate = low.opposed_rate - place.opposed_rate
        if rate > 0.0 and tie < low.low - place.low < rate * first.length:
            first = Event((low.low - place.low) / rate, -1, -1, 0.0, 0)
    return first


@inlined
def first_event(
    circuit: Circuit,
    places: NDArray[Any],
    currents: NDArray[np.float64],
    neutral: Neutral,
    length: float,
) -> Event:
    """Return the first event of a stretch.

    `currents`, shape (m,): phase currents at the start of the stretch (A). `length`: maximum length of the stretch
    (s). Result: with the maximum length and without a phase if there is no event.
    """
    if neutral.moving == 0:
        return _separation_event(places, TIE * circuit.source, length)
    first = Event(length, -1, -1, 0.0, 0)
    phis = phis_at(circuit.rate * length)
    for k in range(places.size):
        place = places[k]
        if place.tread == HELD:
            time, side = _voltage_event(place, neutral)
            level = 0.0
        else:
            bound_motion(circuit, place)
            if first.phase >= 0 and first.side == 0 and _is_mirror_image(place, places[first.phase]):
                # It reaches its level at the same instant; a second search would be expensive.
                continue
            time, level = _current_event(circuit.rate, place, currents[k], length, phis)
            side = 0
        if time < first.length or (time == first.length and first.phase < 0 and time < inf):
            first = Event(max(time, 0.0), k, -1, level, side)
    return first
