"""Three Hall switches: six edges per electrical cycle, and a timer that measures speed and angle from them.

The switches of a conventional brushless DC drive change where a conduction window of 120 degrees opens or closes
without advance, every 60 electrical degrees. Each edge has a placement error, and is delayed by the switches'
hysteresis. Speed and angle are computed from the times of the edges alone:

- The speed is the mean over the last electrical cycle, between an edge and the same edge one cycle before. Between
  consecutive edges, a placement error of 1.5 degrees would cause a speed error of 5 %; between equal edges the errors
  cancel. Until a cycle has passed, the speed uses the available edges; before the second edge it is 0.
- Without a new edge, the speed is at most one sector over the time since the last edge, so it falls toward 0. A sector
  is 60 degrees plus the maximum placement errors of its two edges.
- The angle is extrapolated from the last edge with that speed, within the 60 degrees up to the nominal place of the
  next edge. Without a speed it is the middle of the sector, which results in block commutation.
- The order of the states shows the sense of rotation. After a reversal, the timer starts again from the next edge.

The inverter's conduction windows use that angle. Its error shifts the advance; the mean of the error over a control
period is exact, because the shaft's speed is constant within it.
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
"""Electrical angle between two edges (rad)."""
FIRST_EDGE: Final = pi / 6.0
"""Electrical angle of the first edge, where the first phase's window of 120 degrees opens without advance (rad)."""

# The same edge one cycle ago is six edges back, so both ends need a place.
_RING = EDGES + 1
_SINCE = 0
_MEASURED = 1
_NUMBER = 0
_TIMED = 1
_UNSEEN = 2
_TO_LOSE = 3
_SENSE = 4
# Minimum distance of the angle from the ends of its sector (rad), so that rounding does not commutate before an edge.
_INSIDE = 1e-6
# Electrical speed (rad/s) below which no edge is timed.
_AT_REST = 1e-6
# Electrical cycles per control period beyond which the switches are not simulated.
_BLURRED = 1000.0
_CYCLE = 2.0 * pi


class Hall(NamedTuple):
    """Constants of the switches and the state of their timer; the arrays are updated in place."""

    present: bool
    """True if there are Hall switches, which then measure speed and angle."""
    pole_pairs: float
    """Electrical cycles per turn (1)."""
    clock: float
    """Resolution of the edges' times (s)."""
    longest: float
    """Maximum angle between two consecutive edges (rad electrical)."""
    lags: NDArray[np.float64]
    """Delay of each edge in forward rotation, including hysteresis, shape (6,) (rad electrical)."""
    backlash: float
    """Angle between the places of an edge in both senses of rotation: twice the hysteresis (rad electrical)."""
    ticks: NDArray[np.float64]
    """Start times of the last sectors, a ring buffer by their numbers, shape (7,) (clock ticks)."""
    numbers: NDArray[np.int64]
    """Number of the sector, counted from the electrical angle 0; number of timed edges; number of sectors by which the
    states lag; number of edges to be lost; sense of rotation, 1 or -1; shape (5,)."""
    memory: NDArray[np.float64]
    """Angle since the start of the sector in forward rotation (rad electrical), and measured speed of the shaft
    (rad/s), shape (2,)."""


def no_hall() -> Hall:
    """Return a placeholder for a drive without Hall switches."""
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
    """Return switches on a shaft that has turned at constant speed for a long time, or is at rest.

    - `pole_pairs`: electrical cycles per turn.
    - `placement_errors`, shape (6,): angle by which each edge lies behind its nominal place (rad electrical).
    - `greatest_error`: maximum magnitude of a placement error (rad electrical), which the timer's program knows.
    - `hysteresis`: angle by which every edge is delayed in the sense of rotation (rad electrical).
    - `clock`: resolution of the edges' times (s).
    - `initial_angle`: electrical angle of the rotor, 0 to 2 pi (rad).
    - `initial_speed`: speed of the shaft, of either sign (rad/s). At rest, no edge is timed yet.
    - Result: with the times of the last cycle's edges if the shaft turns.
    """
    lags = placement_errors + hysteresis
    electrical = pole_pairs * initial_speed
    sense = -1 if electrical < -_AT_REST else 1
    # Backward, every edge comes earlier by the hysteresis of both senses.
    earlier = 2.0 * hysteresis if sense < 0 else 0.0
    places = FIRST_EDGE + SECTOR * np.arange(EDGES) + lags - earlier
    turned = initial_angle - places
    cycles = np.floor(turned / _CYCLE)
    turned -= _CYCLE * cycles
    nearest = int(np.argmin(turned))
    last = nearest + EDGES * int(cycles[nearest])
    is_turning = abs(electrical) > _AT_REST
    ticks = np.zeros(_RING)
    if is_turning:
        for before in range(_RING):
            number = last - sense * before
            # A sector is entered at its end backward.
            edge = number if sense > 0 else number + 1
            angle = turned[nearest] + SECTOR * (last - edge) + lags[nearest] - lags[edge % EDGES]
            ticks[number % _RING] = floor(-angle / electrical / clock)
    return Hall(
        present=True,
        pole_pairs=float(pole_pairs),
        clock=clock,
        longest=SECTOR + 2.0 * greatest_error,
        lags=lags,
        backlash=2.0 * hysteresis,
        ticks=ticks,
        numbers=np.array([last, _RING if is_turning else 0, 0, 0, sense]),
        memory=np.array([turned[nearest] - earlier, initial_speed if is_turning else 0.0]),
    )


@inlined
def hall_speed(hall: Hall) -> float:
    """Return the measured speed of the shaft (rad/s)."""
    return float(hall.memory[_MEASURED])


@inlined
def lose_switching(hall: Hall) -> None:
    """Skip the next edge of the switches.

    The states do not change for one more sector, and change by two sectors at the edge after it. This shows the
    timer's program that one edge was lost.
    """
    hall.numbers[_TO_LOSE] += 1


@inlined
def _seen_sector(hall: Hall) -> int:
    """Return the number of the sector indicated by the states."""
    return int(hall.numbers[_NUMBER] - hall.numbers[_UNSEEN])


@inlined
def _time_edge(hall: Hall, number: int, passed: int, tick: float) -> None:
    """Store the start of a sector (clock ticks), `passed` sectors after the last one; interpolate lost edges."""
    sense = 1 if passed > 0 else -1
    first = number - passed
    begin = hall.ticks[first % _RING]
    count = sense * passed
    for lost in range(1, count):
        hall.ticks[(first + sense * lost) % _RING] = begin + floor((tick - begin) * lost / count)
    hall.ticks[number % _RING] = tick
    timed = hall.numbers[_TIMED]
    # Edges of the two senses differ by the hysteresis, so edges of the other sense do not count.
    is_first = timed == 0 or hall.numbers[_SENSE] != sense
    hall.numbers[_TIMED] = 1 if is_first else min(timed + count, _RING)
    hall.numbers[_SENSE] = sense


@inlined
def hall_bits(hall: Hall) -> int:
    """Return the states of the switches as bits, with the first phase as the lowest bit.

    They are 1, 3, 2, 6, 4 and 5 in the sectors of a cycle, beginning at `FIRST_EDGE`.
    """
    sector = _seen_sector(hall) % EDGES
    bits = 0
    for phase in range(3):
        # Each switch is on for half a cycle, which begins a third of a cycle after the preceding switch.
        if (sector - 2 * phase + 1) % EDGES < 3:
            bits += 1 << phase
    return bits


@inlined
def hall_angle(hall: Hall, now: float) -> float:
    """Return the timer's estimate of the electrical angle.

    `now`: time (s). Result: angle within the present sector (rad electrical).
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
    """Return the timer's estimate of the shaft's angle, with counted electrical cycles.

    `now`: time (s). Result: angle since the shaft's angle 0 (rad); it may be slightly outside one turn.
    """
    cycle = (_seen_sector(hall) // EDGES) % int(hall.pole_pairs)
    return (hall_angle(hall, now) + _CYCLE * cycle) / hall.pole_pairs


@inlined
def _mean_angle(speed: float, begin: float, end: float) -> float:
    """Return the mean of the angle extrapolated from an edge (rad), between two times after it (s)."""
    if speed == 0.0:
        return 0.5 * SECTOR
    if speed < 0.0:
        return SECTOR - _mean_forward(-speed, begin, end)
    return _mean_forward(speed, begin, end)


@inlined
def _mean_forward(speed: float, begin: float, end: float) -> float:
    """Return the mean of the angle extrapolated from an edge with a positive speed (rad)."""
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
    """Return the speed of the shaft, computed from the times of the last edges (rad/s)."""
    number = _seen_sector(hall)
    timed = hall.numbers[_TIMED]
    if timed < 2:
        return 0.0
    sectors = min(timed, _RING) - 1
    last = float(hall.ticks[number % _RING])
    # The clock limits the measurable speed.
    sense = hall.numbers[_SENSE]
    first = float(hall.ticks[(number - sense * sectors) % _RING])
    span = max(last - first, 1.0) * hall.clock
    electrical = sectors * SECTOR / span
    # The edge may have occurred anywhere in its tick.
    elapsed = now - (last + 1.0) * hall.clock
    if elapsed * electrical > hall.longest:
        electrical = hall.longest / elapsed
    return float(sense * electrical / hall.pole_pairs)


@unallocating
def turn_hall(hall: Hall, time: float, period: float, speed: float) -> float:
    """Advance the shaft by one control period, and measure the speed at its end.

    `time`: start of the period (s). `period`: length of the period (s). `speed`: true speed of the shaft, of either
    sign (rad/s). Result: mean over the period of the timer's angle minus the true one (rad electrical).
    """
    lags = hall.lags
    numbers = hall.numbers
    electrical = hall.pole_pairs * speed
    absolute_speed = abs(electrical)
    if absolute_speed * period > _BLURRED * _CYCLE:
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
        remaining = width - since if sense > 0 else since + hall.backlash
        # Divide only if the edge occurs within the period: a shaft close to rest reaches it at no finite time.
        to_edge = (
            max(remaining, 0.0) / absolute_speed
            if absolute_speed > 0.0 and remaining <= absolute_speed * period
            else inf
        )
        length = min(to_edge, period - passed)
        begin = time + passed - hall.ticks[(number - unseen) % _RING] * hall.clock
        seen = _mean_angle(measured if numbers[_TIMED] > 0 else 0.0, begin, begin + length)
        error += length * (seen - lag - since - 0.5 * electrical * length - SECTOR * unseen)
        if to_edge > period - passed:
            since += electrical * length
            break
        passed += to_edge
        number += sense
        # In backward rotation a sector is entered at its end, earlier by the hysteresis of both senses.
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
