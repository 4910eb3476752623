"""A quadrature encoder whose edges are counted and timed.

Its edges are exact, because the speed is constant within a control period. A counter and the time of its last edge are
sampled once per control period. The speed is the number of edges over the time between the last edges of two samples
(paper, Fig. 8: high-speed inputs).
"""

from __future__ import annotations

from math import floor, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

_POSITION = 0
_FALSE_COUNTS = 1
_MEASURED = 2
_TO_LOSE = 3
_EDGES_A_LINE = 4


class Encoder(NamedTuple):
    """Constants of the encoder and the state of its counter and timer; the arrays are updated in place."""

    edge_angle: float
    """Shaft angle between two edges (rad)."""
    clock: float
    """Resolution of the edges' times (s)."""
    counts: NDArray[np.int64]
    """Counter at the samples of the last speed window, shape (n,)."""
    ticks: NDArray[np.float64]
    """Time of the last edge before each sample, shape (n,) (clock ticks)."""
    memory: NDArray[np.float64]
    """Position (edges), sum of false and lost edges, measured speed (rad/s), edges yet to be lost, shape (4,)."""
    glitches: NDArray[np.float64]
    """Time (s) and number of edges of each burst of false edges, shape (g, 2)."""


def no_encoder() -> Encoder:
    """Return a placeholder for a drive without an encoder."""
    return Encoder(1.0, 1.0, np.zeros(1, np.int64), np.zeros(1), np.zeros(4), np.zeros((0, 2)))


def turning_encoder(
    *,
    lines: int,
    speed_window: float,
    clock: float,
    control_period: float,
    initial_speed: float,
    initial_angle: float = 0.0,
    glitches: NDArray[np.float64],
) -> Encoder:
    """Return an encoder whose shaft has turned at constant speed for a long time.

    - `lines`: lines per turn; each line has four edges.
    - `speed_window`: time over which edges are counted (s).
    - `clock`: resolution of the edges' times (s).
    - `control_period`: time between two samples of the counter (s).
    - `initial_speed`: speed of the shaft, of either sign (rad/s).
    - `initial_angle`: angle of the shaft at the start, and of the initial count (rad).
    - `glitches`, shape (g, 2): time (s) and number of edges of each burst of false edges.
    """
    edge_angle = 2.0 * pi / (_EDGES_A_LINE * lines)
    looks = max(round(speed_window / control_period), 1)
    # The samples of the past, so that the measured speed of a turning shaft does not begin at zero.
    times = (np.arange(looks) - looks + 1.0) * control_period
    begin = initial_angle / edge_angle
    positions = begin + initial_speed * times / edge_angle
    whole = np.floor(positions)
    if initial_speed > 0.0:
        since = (positions - whole) * edge_angle / initial_speed
    elif initial_speed < 0.0:
        since = (positions - whole - 1.0) * edge_angle / initial_speed
    else:
        # At rest there was no edge. One second ago is long ago: the first edges show a low speed.
        since = np.full(looks, 1.0)
    return Encoder(
        edge_angle=edge_angle,
        clock=clock,
        counts=whole.astype(np.int64),
        ticks=np.floor((times - since) / clock),
        memory=np.array([begin, 0.0, initial_speed, 0.0]),
        glitches=glitches,
    )


@inlined
def encoder_speed(encoder: Encoder) -> float:
    """Return the measured speed of the shaft (rad/s)."""
    return float(encoder.memory[_MEASURED])


@inlined
def encoder_count(encoder: Encoder) -> int:
    """Return the counter: edges since angle 0, false ones included, negative below it."""
    return int(floor(encoder.memory[_POSITION]) + encoder.memory[_FALSE_COUNTS])


@inlined
def count_within_a_turn(encoder: Encoder) -> int:
    """Return the counter modulo the number of edges per turn."""
    return encoder_count(encoder) % round(2.0 * pi / encoder.edge_angle)


@inlined
def lose_count(encoder: Encoder) -> None:
    """Omit the next edge from the count.

    From that edge on the count is off by one. The number of edges for the speed is off by one while the edge is
    within the speed window.
    """
    encoder.memory[_TO_LOSE] += 1.0


@inlined
def _without_lost(encoder: Encoder, edges: float) -> float:
    """Return the number of counted edges in a control period, of either sign, without one that is to be lost."""
    if encoder.memory[_TO_LOSE] <= 0.0 or edges == 0.0:
        return edges
    encoder.memory[_TO_LOSE] -= 1.0
    lost = 1.0 if edges > 0.0 else -1.0
    encoder.memory[_FALSE_COUNTS] -= lost
    return edges - lost


@inlined
def turn_encoder(encoder: Encoder, step: int, time: float, period: float, speed: float) -> None:
    """Advance the encoder by one control period, and measure the speed at its end.

    `step`: number of the control period, from 0. `time`: start of the period (s). `period`: length of the period (s).
    `speed`: true speed of the shaft, of either sign (rad/s).
    """
    memory = encoder.memory
    counts = encoder.counts
    ticks = encoder.ticks
    # A ring buffer: this sample overwrites the one from a speed window ago.
    slot = step % counts.size
    before = memory[_POSITION]
    after = before + speed * period / encoder.edge_angle
    whole = floor(after)
    tick = ticks[(step - 1) % counts.size]
    if _without_lost(encoder, whole - floor(before)) != 0.0:
        # Exact, since the speed is constant within the period; the timer rounds it down.
        last = whole if speed > 0.0 else whole + 1.0
        edge = time + period - (after - last) * encoder.edge_angle / speed
        tick = floor(edge / encoder.clock)
    memory[_POSITION] = after
    glitches = encoder.glitches
    for row in range(glitches.shape[0]):
        if time <= glitches[row, 0] < time + period:
            memory[_FALSE_COUNTS] += glitches[row, 1]
    count = int(whole + memory[_FALSE_COUNTS])
    edges = count - counts[slot]
    span = tick - ticks[slot]
    if edges != 0 and span > 0.0:
        memory[_MEASURED] = edges * encoder.edge_angle / (span * encoder.clock)
    else:
        # No edge within the window: the speed is below one edge over the time that has passed since the last.
        elapsed = max(time + period - tick * encoder.clock, period)
        slowest = encoder.edge_angle / elapsed
        memory[_MEASURED] = max(min(memory[_MEASURED], slowest), -slowest)
    counts[slot] = count
    ticks[slot] = tick
