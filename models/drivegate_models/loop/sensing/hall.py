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
    """Electrical angle by which each edge comes late, hysteresis included, shape (6,) (rad)."""
    ticks: NDArray[np.float64]
    """Times of the last edges, a ring by their numbers, shape (7,) (clock ticks)."""
    numbers: NDArray[np.int64]
    """Number of the last edge, how many edges are timed, how many of the last ones were lost, and how many are yet to
    be, shape (4,)."""
    memory: NDArray[np.float64]
    """Electrical angle turned since the last edge (rad), measured speed of the shaft (rad/s), shape (2,)."""


def no_hall() -> Hall:
    """Make room for Hall switches where there are none."""
    return Hall(False, 1.0, 1.0, SECTOR, np.zeros(EDGES), np.zeros(_RING), np.zeros(4, np.int64), np.zeros(2))


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
        Speed at which it has turned (rad/s); 0 at rest, where no edge is timed yet.

    Returns
    -------
    Hall
        The switches.
    """
    lags = placement_errors + hysteresis
    places = FIRST_EDGE + SECTOR * np.arange(EDGES) + lags
    turned = initial_angle - places
    turned -= _CYCLE * np.floor(turned / _CYCLE)
    last = int(np.argmin(turned))
    electrical = pole_pairs * initial_speed
    is_turning = electrical > _AT_REST
    ticks = np.zeros(_RING)
    if is_turning:
        for before in range(_RING):
            angle = turned[last] + SECTOR * before + lags[last] - lags[(last - before) % EDGES]
            ticks[(last - before) % _RING] = floor(-angle / electrical / clock)
    return Hall(
        present=True,
        pole_pairs=float(pole_pairs),
        clock=clock,
        longest=SECTOR + 2.0 * greatest_error,
        lags=lags,
        ticks=ticks,
        numbers=np.array([last, _RING if is_turning else 0, 0, 0]),
        memory=np.array([turned[last], initial_speed if is_turning else 0.0]),
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
        The switches: they keep their state for one more sector, and change by two with the edge behind it, from whose
        state the timer's program tells that one was lost.
    """
    hall.numbers[_TO_LOSE] += 1


@inlined
def _seen_edge(hall: Hall) -> int:
    """Return the number of the last edge that has come."""
    return int(hall.numbers[_NUMBER] - hall.numbers[_UNSEEN])


@inlined
def _time_edge(hall: Hall, number: int, unseen: int, tick: float) -> None:
    """Keep an edge's time, and as those of lost ones before it times that part the way to it evenly (clock ticks)."""
    first = number - unseen - 1
    begin = hall.ticks[first % _RING]
    for lost in range(1, unseen + 1):
        hall.ticks[(first + lost) % _RING] = begin + floor((tick - begin) * lost / (unseen + 1))
    hall.ticks[number % _RING] = tick


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
    sector = _seen_edge(hall) % EDGES
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
    number = _seen_edge(hall)
    begin = FIRST_EDGE + SECTOR * (number % EDGES)
    electrical = hall.pole_pairs * hall.memory[_MEASURED]
    if hall.numbers[_TIMED] == 0 or electrical <= 0.0:
        return float(begin + 0.5 * SECTOR)
    elapsed = now - hall.ticks[number % _RING] * hall.clock
    return float(begin + min(max(electrical * elapsed, _INSIDE), SECTOR - _INSIDE))


@inlined
def _mean_angle(speed: float, begin: float, end: float) -> float:
    """Return the mean of the angle that goes on from an edge with a speed (rad), between two times after it (s)."""
    if speed <= 0.0:
        return 0.5 * SECTOR
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
def _measured_speed(hall: Hall, number: int, timed: int, now: float) -> float:
    """Return the speed of the shaft that the times of the last edges tell at a time (rad/s)."""
    if timed < 2:
        return 0.0
    sectors = min(timed, _RING) - 1
    last = float(hall.ticks[number % _RING])
    # Faster than the clock nothing is seen.
    first = float(hall.ticks[(number - sectors) % _RING])
    span = max(last - first, 1.0) * hall.clock
    electrical = sectors * SECTOR / span
    # The edge may have come anywhere in its tick.
    elapsed = now - (last + 1.0) * hall.clock
    if elapsed * electrical > hall.longest:
        electrical = hall.longest / elapsed
    return electrical / hall.pole_pairs


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
        True speed of the shaft (rad/s).

    Returns
    -------
    float
        Mean over the period of the angle that the timer goes by, less the true one (rad electrical).
    """
    lags = hall.lags
    ticks = hall.ticks
    electrical = hall.pole_pairs * speed
    if electrical * period > _BLURRED * _CYCLE:
        return 0.0
    measured = hall.pole_pairs * hall.memory[_MEASURED]
    since = hall.memory[_SINCE]
    number = hall.numbers[_NUMBER]
    timed = hall.numbers[_TIMED]
    unseen = hall.numbers[_UNSEEN]
    passed = 0.0
    error = 0.0
    while passed < period:
        lag = lags[number % EDGES]
        left = SECTOR + lags[(number + 1) % EDGES] - lag - since
        # Divided only where an edge is within reach: a shaft that all but rests would reach it at no finite time.
        to_edge = max(left, 0.0) / electrical if electrical > 0.0 and left <= electrical * period else inf
        length = min(to_edge, period - passed)
        begin = time + passed - ticks[(number - unseen) % _RING] * hall.clock
        seen = _mean_angle(measured if timed > 0 else 0.0, begin, begin + length)
        error += length * (seen - lag - since - 0.5 * electrical * length - SECTOR * unseen)
        if to_edge > period - passed:
            since += electrical * length
            break
        passed += to_edge
        number += 1
        since = 0.0
        if hall.numbers[_TO_LOSE] > 0:
            hall.numbers[_TO_LOSE] -= 1
            unseen += 1
            continue
        _time_edge(hall, number, unseen, floor((time + passed) / hall.clock))
        timed = min(timed + 1 + unseen, _RING) if timed > 0 else 1
        unseen = 0
    hall.numbers[_NUMBER] = number
    hall.numbers[_TIMED] = timed
    hall.numbers[_UNSEEN] = unseen
    hall.memory[_SINCE] = since
    hall.memory[_MEASURED] = _measured_speed(hall, number - unseen, timed, time + period)
    return error / period
