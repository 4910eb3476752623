"""A quadrature encoder whose edges are counted and timed.

Its edges are exact, since the speed is constant within a control period. A counter and the time of its last edge
are looked at once a control period; the speed is the number of edges over the time between the last edges of two
such looks (paper, Fig. 8: high-speed inputs).
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
    """Constants of the encoder and what its counter and timer remember; the arrays are updated in place."""

    edge_angle: float
    """Shaft angle between two edges (rad)."""
    clock: float
    """Resolution of the edges' times (s)."""
    counts: NDArray[np.int64]
    """Counter at the looks of the last speed window, shape (n,)."""
    ticks: NDArray[np.float64]
    """Time of the last edge before each look, shape (n,) (clock ticks)."""
    memory: NDArray[np.float64]
    """Position (edges), sum of false and lost edges, measured speed (rad/s), edges yet to be lost, shape (4,)."""
    glitches: NDArray[np.float64]
    """Time (s) and number of edges of each burst of false edges, shape (g, 2)."""


def no_encoder() -> Encoder:
    """Make room for an encoder where there is none."""
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
    """Make an encoder that has turned for a long time.

    Parameters
    ----------
    lines : int
        Lines a turn; it gives four edges a line.
    speed_window : float
        Time over which edges are counted (s).
    clock : float
        Resolution of the edges' times (s).
    control_period : float
        Time between two looks at the counter (s).
    initial_speed : float
        Speed at which it has turned, of either sign (rad/s).
    initial_angle : float
        Angle of the shaft that the count begins with (rad).
    glitches : ndarray, shape (g, 2)
        Time (s) and number of edges of each burst of false edges.

    Returns
    -------
    Encoder
        The encoder.
    """
    edge_angle = 2.0 * pi / (_EDGES_A_LINE * lines)
    looks = max(round(speed_window / control_period), 1)
    # The looks that a shaft already turning has left, so that the measured speed does not begin at zero.
    times = (np.arange(looks) - looks + 1.0) * control_period
    begin = initial_angle / edge_angle
    positions = begin + initial_speed * times / edge_angle
    whole = np.floor(positions)
    if initial_speed > 0.0:
        since = (positions - whole) * edge_angle / initial_speed
    elif initial_speed < 0.0:
        since = (positions - whole - 1.0) * edge_angle / initial_speed
    else:
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
    """Return the measured speed (rad/s).

    Parameters
    ----------
    encoder : Encoder
        The encoder.

    Returns
    -------
    float
        Of the shaft.
    """
    return float(encoder.memory[_MEASURED])


@inlined
def encoder_count(encoder: Encoder) -> int:
    """Return the counter's state.

    Parameters
    ----------
    encoder : Encoder
        The encoder.

    Returns
    -------
    int
        Edges since the angle that it counts from, false ones included; below zero behind it.
    """
    return int(floor(encoder.memory[_POSITION]) + encoder.memory[_FALSE_COUNTS])


@inlined
def count_within_a_turn(encoder: Encoder) -> int:
    """Return the counter's state less whole turns of the shaft.

    Parameters
    ----------
    encoder : Encoder
        The encoder.

    Returns
    -------
    int
        From 0 to one less than the edges of a turn.
    """
    return encoder_count(encoder) % round(2.0 * pi / encoder.edge_angle)


@inlined
def lose_count(encoder: Encoder) -> None:
    """Let the counter miss the next edge.

    Parameters
    ----------
    encoder : Encoder
        Updated: from that edge on its count is off by one, and so is the number of edges that the speed follows from
        while the edge lies within the speed window.
    """
    encoder.memory[_TO_LOSE] += 1.0


@inlined
def _without_lost(encoder: Encoder, edges: float) -> float:
    """Return how many of the edges of a control period are seen, of either sign, with one that is lost taken off."""
    if encoder.memory[_TO_LOSE] <= 0.0 or edges == 0.0:
        return edges
    encoder.memory[_TO_LOSE] -= 1.0
    lost = 1.0 if edges > 0.0 else -1.0
    encoder.memory[_FALSE_COUNTS] -= lost
    return edges - lost


@inlined
def turn_encoder(encoder: Encoder, step: int, time: float, period: float, speed: float) -> None:
    """Let the encoder turn for one control period, and measure the speed at its end.

    Parameters
    ----------
    encoder : Encoder
        Updated.
    step : int
        Number of the control period.
    time : float
        Its start (s).
    period : float
        Its length (s).
    speed : float
        True speed of the shaft, of either sign (rad/s).
    """
    memory = encoder.memory
    counts = encoder.counts
    ticks = encoder.ticks
    # A ring: what this look overwrites is the one a speed window ago.
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
