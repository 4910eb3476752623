"""Three Hall switches: six edges an electrical cycle, and what a timer of their edges makes of speed and angle.

The switches of a conventional brushless DC drive change where a conduction window of 120 degrees opens or closes
without advance, every 60 electrical degrees. Each edge has an error of its placement, and comes later by the
switches' hysteresis. Speed and angle come from the edges' times alone:

- The speed is that of the last electrical cycle, between an edge and the same edge one cycle before. Between two
  edges that follow each other, 1.5 degrees of placement would be 5 % of speed; between like ones they cancel. Until
  a cycle has passed, the edges that there are must do; before the second one the speed is 0.
- While no edge comes the speed is no more than a sector over the time since the last one, so it falls toward 0. A
  sector is 60 degrees and what its two edges may be out of place.
- The angle goes on from the last edge with that speed, within the 60 degrees up to the next edge's place. Without a
  speed it is the sector's middle, which commutates block by block.
- The order of the states shows the sense of rotation. Where it reverses, the timer starts again from the next edge.

The inverter's windows rest on that angle. What they are off by is a shift of the advance; of its course within a
control period the mean counts, which is exact since the shaft's speed is constant then.
"""

from __future__ import annotations

from math import floor, inf, pi
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating

EDGES: Final = 6
"""Edges of three switches in an electrical cycle."""
SECTOR: Final = pi / 3.0
"""Electrical angle between two of them (rad)."""
FIRST_EDGE: Final = pi / 6.0
"""Electrical angle of the first one, where the first phase's window of 120 degrees opens without advance (rad)."""

_RING = EDGES + 1
_SINCE = 0
_MEASURED = 1
_NUMBER = 0
_TIMED = 1
_UNSEEN = 2
_TO_LOSE = 3
_SENSE = 4
# The angle stays inside its sector by so much (rad), so that rounding commutates no edge that has not come.
_INSIDE = 1e-6
# So slow (rad/s) that a timer that has run for a long time has no edge of it.
_AT_REST = 1e-6
# Cycles in a control period that no switch follows.
_BLURRED = 1000.0
_CYCLE = 2.0 * pi


class Hall(NamedTuple):
    """Constants of the switches and what the timer of their edges remembers; the arrays are updated in place."""

    present: bool
    """Whether there are such switches, which then give speed and angle."""
    pole_pairs: float
    """Electrical cycles a turn (1)."""
    clock: float
    """Resolution of the edges' times (s)."""
    longest: float
    """Greatest angle between two edges that follow each other (rad electrical)."""
    lags: NDArray[np.float64]
    """Electrical angle by which each edge comes late forward, hysteresis included, shape (6,) (rad)."""
    backlash: float
    """Electrical angle between the places of an edge forward and backward: twice the hysteresis (rad)."""
    ticks: NDArray[np.float64]
    """Times at which the last sectors began, a ring by their numbers, shape (7,) (clock ticks)."""
    numbers: NDArray[np.int64]
    """Number of the sector, counted from the electrical angle 0; how many edges are timed; by how many sectors the
    states lag; how many edges are yet to be lost; and the sense of rotation, 1 or -1; shape (5,)."""
    memory: NDArray[np.float64]
    """Electrical angle since the place where the sector begins forward (rad), measured speed of the shaft (rad/s),
    shape (2,)."""


def no_hall() -> Hall:
    """Make room for Hall switches where there are none."""
    numbers = np.array([0, 0, 0, 0, 1])
    return Hall(False, 1.0, 1.0, SECTOR, np.zeros(EDGES), 0.0, np.zeros(_RING), numbers, np.zeros(2))


def turning_hall(
    *,
    pole_pairs: int,
    placement_errors: NDArray[np.float64],
    greatest_error: float,
    hysteresis: float,
    clock: float,
    initial_angle: float,
    initial_speed: float,
) -> Hall:
    """Make switches on a shaft that has turned for a long time, or rests.

    Parameters
    ----------
    pole_pairs : int
        Electrical cycles a turn.
    placement_errors : ndarray, shape (6,)
        Electrical angle by which each edge lies behind its place (rad).
    greatest_error : float
        Greatest magnitude that they may have (rad electrical), which the timer's program knows.
    hysteresis : float
        Electrical angle by which every edge comes later in the sense of rotation (rad).
    clock : float
        Resolution of the edges' times (s).
    initial_angle : float
        Electrical angle of the rotor, 0 to 2 pi (rad).
    initial_speed : float
        Speed at which it has turned forward (rad/s); at rest, and backward, no edge is timed yet.

    Returns
    -------
    Hall
        The switches.
    """
    lags = placement_errors + hysteresis
    places = FIRST_EDGE + SECTOR * np.arange(EDGES) + lags
    turned = initial_angle - places
    cycles = np.floor(turned / _CYCLE)
    turned -= _CYCLE * cycles
    nearest = int(np.argmin(turned))
    last = nearest + EDGES * int(cycles[nearest])
    electrical = pole_pairs * initial_speed
    is_turning = electrical > _AT_REST
    ticks = np.zeros(_RING)
    if is_turning:
        for before in range(_RING):
            angle = turned[nearest] + SECTOR * before + lags[nearest] - lags[(last - before) % EDGES]
            ticks[(last - before) % _RING] = floor(-angle / electrical / clock)
    return Hall(
        present=True,
        pole_pairs=float(pole_pairs),
        clock=clock,
        longest=SECTOR + 2.0 * greatest_error,
        lags=lags,
        backlash=2.0 * hysteresis,
        ticks=ticks,
        numbers=np.array([last, _RING if is_turning else 0, 0, 0, 1]),
        memory=np.array([turned[nearest], initial_speed if is_turning else 0.0]),
    )


@inlined
def hall_speed(hall: Hall) -> float:
    """Return the measured speed.

    Parameters
    ----------
    hall : Hall
        The switches.

    Returns
    -------
    float
        Of the shaft (rad/s).
    """
    return float(hall.memory[_MEASURED])


@inlined
def lose_switching(hall: Hall) -> None:
    """Let the next edge not come.

    Parameters
    ----------
    hall : Hall
        The switches: their state does not change for one more sector, and changes by two with the edge after it, which
        shows the timer's program that one was lost.
    """
    hall.numbers[_TO_LOSE] += 1


@inlined
def _seen_sector(hall: Hall) -> int:
    """Return the number of the sector that the states show."""
    return int(hall.numbers[_NUMBER] - hall.numbers[_UNSEEN])


@inlined
def _time_edge(hall: Hall, number: int, passed: int, tick: float) -> None:
    """Store when a sector began (clock ticks), some sectors after the one seen before; times of lost edges are even."""
    sense = 1 if passed > 0 else -1
    first = number - passed
    begin = hall.ticks[first % _RING]
    count = sense * passed
    for lost in range(1, count):
        hall.ticks[(first + sense * lost) % _RING] = begin + floor((tick - begin) * lost / count)
    hall.ticks[number % _RING] = tick
    timed = hall.numbers[_TIMED]
    # Edges of the two senses lie apart by the hysteresis, so that none of the other one is counted.
    is_first = timed == 0 or hall.numbers[_SENSE] != sense
    hall.numbers[_TIMED] = 1 if is_first else min(timed + count, _RING)
    hall.numbers[_SENSE] = sense


@inlined
def hall_bits(hall: Hall) -> int:
    """Return the states of the switches as bits, the first phase's the lowest.

    Parameters
    ----------
    hall : Hall
        The switches.

    Returns
    -------
    int
        1, 3, 2, 6, 4 and 5 in the sectors of a cycle, from `FIRST_EDGE` on.
    """
    sector = _seen_sector(hall) % EDGES
    bits = 0
    for phase in range(3):
        # Each switch is on for half a cycle that begins a third of one after the switch before it.
        if (sector - 2 * phase + 1) % EDGES < 3:
            bits += 1 << phase
    return bits


@inlined
def hall_angle(hall: Hall, now: float) -> float:
    """Return the electrical angle that the timer goes by.

    Parameters
    ----------
    hall : Hall
        The switches.
    now : float
        Time (s).

    Returns
    -------
    float
        (rad).
    """
    number = _seen_sector(hall)
    begin = FIRST_EDGE + SECTOR * (number % EDGES)
    electrical = abs(hall.pole_pairs * hall.memory[_MEASURED])
    if hall.numbers[_TIMED] == 0 or electrical == 0.0:
        return float(begin + 0.5 * SECTOR)
    elapsed = now - hall.ticks[number % _RING] * hall.clock
    turned = min(max(electrical * elapsed, _INSIDE), SECTOR - _INSIDE)
    return float(begin + (turned if hall.numbers[_SENSE] > 0 else SECTOR - turned))


@inlined
def hall_shaft_angle(hall: Hall, now: float) -> float:
    """Return the angle of the shaft that the timer goes by, from counted electrical cycles.

    Parameters
    ----------
    hall : Hall
        The switches.
    now : float
        Time (s).

    Returns
    -------
    float
        Since the shaft's angle 0 (rad); it may be a little outside one turn.
    """
    cycle = (_seen_sector(hall) // EDGES) % int(hall.pole_pairs)
    return (hall_angle(hall, now) + _CYCLE * cycle) / hall.pole_pairs


@inlined
def _mean_angle(speed: float, begin: float, end: float) -> float:
    """Return the mean of the angle that goes on from an edge with a speed (rad), between two times after it (s)."""
    if speed == 0.0:
        return 0.5 * SECTOR
    if speed < 0.0:
        return SECTOR - _mean_forward(-speed, begin, end)
    return _mean_forward(speed, begin, end)


@inlined
def _mean_forward(speed: float, begin: float, end: float) -> float:
    """Return the mean of the angle that goes on from an edge with a speed above zero (rad)."""
    greatest = SECTOR - _INSIDE
    if speed * end <= greatest:
        mean = 0.5 * speed * (begin + end)
    elif speed * begin >= greatest:
        mean = greatest
    else:
        rising = greatest / speed - begin
        mean = (0.5 * (speed * begin + greatest) * rising + greatest * (end - begin - rising)) / (end - begin)
    return max(mean, _INSIDE)


@inlined
def _measured_speed(hall: Hall, now: float) -> float:
    """Return the speed of the shaft that follows from the times of the last edges (rad/s)."""
    number = _seen_sector(hall)
    timed = hall.numbers[_TIMED]
    if timed < 2:
        return 0.0
    sectors = min(timed, _RING) - 1
    last = float(hall.ticks[number % _RING])
    # Faster than the clock nothing is seen.
    sense = hall.numbers[_SENSE]
    first = float(hall.ticks[(number - sense * sectors) % _RING])
    span = max(last - first, 1.0) * hall.clock
    electrical = sectors * SECTOR / span
    # The edge may have come anywhere in its tick.
    elapsed = now - (last + 1.0) * hall.clock
    if elapsed * electrical > hall.longest:
        electrical = hall.longest / elapsed
    return float(sense * electrical / hall.pole_pairs)


@unallocating
def turn_hall(hall: Hall, time: float, period: float, speed: float) -> float:
    """Let the shaft turn for one control period, and measure the speed at its end.

    Parameters
    ----------
    hall : Hall
        The switches, updated.
    time : float
        Start of the period (s).
    period : float
        Its length (s).
    speed : float
        True speed of the shaft, of either sign (rad/s).

    Returns
    -------
    float
        Mean over the period of the angle that the timer goes by, less the true one (rad electrical).
    """
    lags = hall.lags
    numbers = hall.numbers
    electrical = hall.pole_pairs * speed
    turning = abs(electrical)
    if turning * period > _BLURRED * _CYCLE:
        return 0.0
    sense = 1 if electrical > 0.0 else -1
    measured = hall.pole_pairs * hall.memory[_MEASURED]
    since = hall.memory[_SINCE]
    passed = 0.0
    error = 0.0
    while passed < period:
        number = numbers[_NUMBER]
        unseen = numbers[_UNSEEN]
        lag = lags[number % EDGES]
        width = SECTOR + lags[(number + 1) % EDGES] - lag
        left = width - since if sense > 0 else since + hall.backlash
        # Divided only where an edge is within reach: a shaft that all but rests would reach it at no finite time.
        to_edge = max(left, 0.0) / turning if turning > 0.0 and left <= turning * period else inf
        length = min(to_edge, period - passed)
        begin = time + passed - hall.ticks[(number - unseen) % _RING] * hall.clock
        seen = _mean_angle(measured if numbers[_TIMED] > 0 else 0.0, begin, begin + length)
        error += length * (seen - lag - since - 0.5 * electrical * length - SECTOR * unseen)
        if to_edge > period - passed:
            since += electrical * length
            break
        passed += to_edge
        number += sense
        # Backward a sector is entered at the place of its end, earlier by the hysteresis of both senses.
        since = 0.0 if sense > 0 else SECTOR + lag - lags[number % EDGES] - hall.backlash
        unseen += sense
        numbers[_NUMBER] = number
        if numbers[_TO_LOSE] > 0:
            numbers[_TO_LOSE] -= 1
        elif unseen != 0:
            _time_edge(hall, number, unseen, floor((time + passed) / hall.clock))
            unseen = 0
        numbers[_UNSEEN] = unseen
    hall.memory[_SINCE] = since
    hall.memory[_MEASURED] = _measured_speed(hall, time + period)
    return error / period
