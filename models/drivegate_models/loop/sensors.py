"""Sensors between the plant and its controller: ideal ones, or those of the published implementation.

The encoder's edges are exact, since the speed is constant within a control period. A counter and the time of its
last edge are looked at once a control period; the speed is the number of edges over the time between the last
edges of two such looks (paper, Fig. 8: high-speed inputs). Currents and supply pass a gain, an offset, noise and
a converter of finite steps and range.
"""

from __future__ import annotations

from math import floor, pi, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

SPEED: Final = 0
"""Signal that drops out: the measured speed."""
CURRENTS: Final = 1
"""Signal that drops out: the phase currents and the sum of their magnitudes."""
SUPPLY: Final = 2
"""Signal that drops out: the supply voltage."""
FIRST_PHASE: Final = 3
"""Signal that drops out: the current of the first phase alone; the other phases have the numbers after it."""

_POSITION = 0
_FALSE_COUNTS = 1
_MEASURED = 2
_EDGES_A_LINE = 4
# The generator of Park and Miller (multiplier of 1993): one number of state, and no product beyond 64 bits.
_MODULUS = 2147483647
_MULTIPLIER = 48271
# The sum of four even draws has a variance of a third.
_UNIT_VARIANCE = sqrt(3.0)


class Sensors(NamedTuple):
    """Constants of the sensors and what they remember; the arrays are updated in place."""

    ideal: bool
    """Whether they show the plant as it is, but for the errors of single phases."""
    biased: bool
    """Whether gains and offsets count, or the samples of single phases are lost."""
    edge_angle: float
    """Shaft angle between two edges of the encoder (rad)."""
    clock: float
    """Resolution of the edges' times (s)."""
    current_step: float
    """Step of the converter (A)."""
    current_range: float
    """Greatest current shown (A)."""
    current_noise: float
    """Standard deviation (A)."""
    voltage_step: float
    """Step of the converter (V)."""
    voltage_range: float
    """Greatest voltage shown (V)."""
    voltage_noise: float
    """Standard deviation (V)."""
    gains: NDArray[np.float64]
    """Gain of each phase's current sensor, shape (m,) (1)."""
    offsets: NDArray[np.float64]
    """Offset of each phase's current sensor, shape (m,) (A)."""
    counts: NDArray[np.int64]
    """Counter at the looks of the last speed window, shape (n,)."""
    ticks: NDArray[np.float64]
    """Time of the last edge before each look, shape (n,) (clock ticks)."""
    memory: NDArray[np.float64]
    """Encoder position (edges), sum of false edges, measured speed (rad/s), shape (3,)."""
    random: NDArray[np.int64]
    """State of the noise, shape (1,)."""
    dropouts: NDArray[np.float64]
    """Signal, start and end (s) of each dropout, shape (d, 3)."""
    glitches: NDArray[np.float64]
    """Time (s) and number of edges of each burst of false edges, shape (g, 2)."""


def ideal_sensors(
    phases: int,
    dropouts: NDArray[np.float64] | None = None,
    gains: NDArray[np.float64] | None = None,
    offsets: NDArray[np.float64] | None = None,
) -> Sensors:
    """Make sensors that show the plant as it is, but for the errors that are given.

    Parameters
    ----------
    phases : int
        Number of phases.
    dropouts : ndarray, shape (d, 3), optional
        Signal, start and end (s) of each dropout.
    gains, offsets : ndarray, shape (m,), optional
        Gain (1) and offset (A) of each phase's current sensor.

    Returns
    -------
    Sensors
        The sensors.
    """
    dropouts = np.zeros((0, 3)) if dropouts is None else dropouts
    gains = np.ones(phases) if gains is None else gains
    offsets = np.zeros(phases) if offsets is None else offsets
    lost = bool((dropouts[:, 0] >= FIRST_PHASE).any())
    return Sensors(
        ideal=True,
        biased=lost or bool((gains != 1.0).any() or (offsets != 0.0).any()),
        edge_angle=1.0,
        clock=1.0,
        current_step=0.0,
        current_range=np.inf,
        current_noise=0.0,
        voltage_step=0.0,
        voltage_range=np.inf,
        voltage_noise=0.0,
        gains=gains,
        offsets=offsets,
        counts=np.zeros(1, np.int64),
        ticks=np.zeros(1),
        memory=np.zeros(3),
        random=np.ones(1, np.int64),
        dropouts=dropouts,
        glitches=np.zeros((0, 2)),
    )


def real_sensors(
    phases: int,
    *,
    encoder_lines: int,
    speed_window: float,
    clock: float,
    current_range: float,
    current_gain_spread: float,
    current_offset: float,
    current_noise: float,
    voltage_range: float,
    voltage_noise: float,
    converter_bits: int,
    control_period: float,
    initial_speed: float,
    seed: int,
    dropouts: NDArray[np.float64],
    glitches: NDArray[np.float64],
    gains: NDArray[np.float64] | None = None,
    offsets: NDArray[np.float64] | None = None,
) -> Sensors:
    """Make sensors with finite steps, errors and noise (paper, Fig. 8).

    Parameters
    ----------
    phases : int
        Number of phases.
    encoder_lines : int
        Lines of the quadrature encoder a turn; it gives four edges a line.
    speed_window : float
        Time over which edges are counted (s).
    clock : float
        Resolution of the edges' times (s).
    current_range : float
        The converter shows currents from minus to plus this (A).
    current_gain_spread, current_offset : float
        Greatest error of a gain (1) and greatest offset (A); each phase's are drawn evenly.
    current_noise, voltage_noise : float
        Standard deviations (A, V).
    voltage_range : float
        The converter shows voltages from 0 to this (V).
    converter_bits : int
        Bits of the converter.
    control_period : float
        Time between two looks at the encoder's counter (s).
    initial_speed : float
        Speed at which the shaft has turned before the run (rad/s).
    seed : int
        Seed of gains, offsets and noise.
    dropouts : ndarray, shape (d, 3)
        Signal, start and end (s) of each dropout.
    glitches : ndarray, shape (g, 2)
        Time (s) and number of edges of each burst of false edges.
    gains, offsets : ndarray, shape (m,), optional
        Gain (1) and offset (A) that a phase's current sensor has besides those that are drawn.

    Returns
    -------
    Sensors
        As after a long time at the initial speed.
    """
    generator = np.random.default_rng(seed)
    edge_angle = 2.0 * pi / (_EDGES_A_LINE * encoder_lines)
    looks = max(round(speed_window / control_period), 1)
    # The looks that a shaft already turning has left, so that the measured speed does not begin at zero.
    times = (np.arange(looks) - looks + 1.0) * control_period
    positions = initial_speed * times / edge_angle
    whole = np.floor(positions)
    since = (positions - whole) * edge_angle / initial_speed if initial_speed > 0.0 else np.full(looks, 1.0)
    steps = 2**converter_bits
    drawn_gains = 1.0 + current_gain_spread * generator.uniform(-1.0, 1.0, phases)
    drawn_offsets = current_offset * generator.uniform(-1.0, 1.0, phases)
    return Sensors(
        ideal=False,
        biased=True,
        edge_angle=edge_angle,
        clock=clock,
        current_step=2.0 * current_range / steps,
        current_range=current_range,
        current_noise=current_noise,
        voltage_step=voltage_range / steps,
        voltage_range=voltage_range,
        voltage_noise=voltage_noise,
        gains=drawn_gains if gains is None else gains * drawn_gains,
        offsets=drawn_offsets if offsets is None else offsets + drawn_offsets,
        counts=whole.astype(np.int64),
        ticks=np.floor((times - since) / clock),
        memory=np.array([0.0, 0.0, initial_speed]),
        random=generator.integers(1, _MODULUS, 1),
        dropouts=dropouts,
        glitches=glitches,
    )


@inlined
def _noise(random: NDArray[np.int64]) -> float:
    """Return noise of unit variance, the scaled sum of four even draws of a multiplicative generator."""
    total = 0.0
    state = random[0]
    for _ in range(4):
        state = (state * _MULTIPLIER) % _MODULUS
        total += state
    random[0] = state
    return (total / _MODULUS - 2.0) * _UNIT_VARIANCE


@inlined
def _converted(value: float, step: float, lowest: float, highest: float) -> float:
    """Return what a converter of finite steps and range shows of a value."""
    return min(max(floor(value / step + 0.5) * step, lowest), highest)


@inlined
def dropped(sensors: Sensors, signal: int, time: float) -> bool:
    """Return whether a signal is lost at a time.

    Parameters
    ----------
    sensors : Sensors
        The sensors.
    signal : int
        `SPEED`, `CURRENTS`, `SUPPLY`, or `FIRST_PHASE` and up.
    time : float
        Time (s).

    Returns
    -------
    bool
        True from a dropout's start to just before its end.
    """
    lost = False
    dropouts = sensors.dropouts
    for row in range(dropouts.shape[0]):
        if dropouts[row, 0] == signal and dropouts[row, 1] <= time < dropouts[row, 2]:
            lost = True
    return lost


@inlined
def shown_speed(sensors: Sensors, time: float, speed: float) -> float:
    """Return the measured speed.

    Parameters
    ----------
    sensors : Sensors
        The sensors.
    time : float
        Time (s).
    speed : float
        True speed (rad/s).

    Returns
    -------
    float
        What the controller senses (rad/s).
    """
    if dropped(sensors, SPEED, time):
        return 0.0
    if sensors.ideal:
        return speed
    return float(sensors.memory[_MEASURED])


@inlined
def shown_supply(sensors: Sensors, time: float, supply: float) -> float:
    """Return the measured voltage of a half-source.

    Parameters
    ----------
    sensors : Sensors
        The sensors; their noise goes on.
    time : float
        Time (s).
    supply : float
        Mean voltage of the half-sources (V).

    Returns
    -------
    float
        What the controller senses (V).
    """
    if dropped(sensors, SUPPLY, time):
        return 0.0
    if sensors.ideal:
        return supply
    seen = supply + sensors.voltage_noise * _noise(sensors.random)
    return _converted(seen, sensors.voltage_step, 0.0, sensors.voltage_range)


@inlined
def show_currents(
    sensors: Sensors,
    time: float,
    currents: NDArray[np.float64],
    magnitudes: NDArray[np.float64],
    period: float,
    shown: NDArray[np.float64],
) -> float:
    """Write the measured phase currents, and return the measured sum of their mean magnitudes.

    Each phase's magnitude is averaged over the period just ended by the sensor's filter; its offset counts with
    the sign that the current has.

    Parameters
    ----------
    sensors : Sensors
        The sensors; their noise goes on.
    time : float
        Time (s).
    currents : ndarray, shape (m,)
        True currents (A).
    magnitudes : ndarray, shape (m,)
        Integrals of their magnitudes over the period just ended (A s).
    period : float
        Its length (s).
    shown : ndarray, shape (m,) or longer
        Receives what the controller senses (A).

    Returns
    -------
    float
        Measured sum of the magnitudes (A).
    """
    total = 0.0
    lost = dropped(sensors, CURRENTS, time)
    for phase in range(currents.size):
        if lost or dropped(sensors, FIRST_PHASE + phase, time):
            shown[phase] = 0.0
            continue
        current = currents[phase]
        mean = magnitudes[phase] / period
        if sensors.biased:
            gain = sensors.gains[phase]
            offset = sensors.offsets[phase]
            # The sensor sees the signed current, and only then is its magnitude taken.
            signed_offset = -offset if current < 0.0 else offset
            mean = abs(gain * mean + signed_offset)
            current = gain * current + offset
        if not sensors.ideal:
            step = sensors.current_step
            greatest = sensors.current_range
            noisy = mean + sensors.current_noise * _noise(sensors.random)
            mean = _converted(noisy, step, 0.0, greatest)
            noisy = current + sensors.current_noise * _noise(sensors.random)
            current = _converted(noisy, step, -greatest, greatest)
        shown[phase] = current
        total += mean
    return total


@inlined
def turn_encoder(sensors: Sensors, step: int, time: float, period: float, speed: float) -> None:
    """Let the encoder turn for one control period, and measure the speed at its end.

    Parameters
    ----------
    sensors : Sensors
        The sensors, updated.
    step : int
        Number of the control period.
    time : float
        Its start (s).
    period : float
        Its length (s).
    speed : float
        True speed of the shaft (rad/s).
    """
    if sensors.ideal:
        return
    memory = sensors.memory
    counts = sensors.counts
    ticks = sensors.ticks
    # A ring: what this look overwrites is the one a speed window ago.
    slot = step % counts.size
    before = memory[_POSITION]
    after = before + speed * period / sensors.edge_angle
    whole = floor(after)
    tick = ticks[(step - 1) % counts.size]
    if whole > floor(before):
        # Exact, since the speed is constant within the period; the timer rounds it down.
        edge = time + period - (after - whole) * sensors.edge_angle / speed
        tick = floor(edge / sensors.clock)
    memory[_POSITION] = after
    glitches = sensors.glitches
    for row in range(glitches.shape[0]):
        if time <= glitches[row, 0] < time + period:
            memory[_FALSE_COUNTS] += glitches[row, 1]
    count = int(whole + memory[_FALSE_COUNTS])
    edges = count - counts[slot]
    span = tick - ticks[slot]
    if edges != 0 and span > 0.0:
        memory[_MEASURED] = edges * sensors.edge_angle / (span * sensors.clock)
    else:
        # No edge within the window: the speed is below one edge over the time that has passed since the last.
        elapsed = max(time + period - tick * sensors.clock, period)
        memory[_MEASURED] = min(memory[_MEASURED], sensors.edge_angle / elapsed)
    counts[slot] = count
    ticks[slot] = tick
