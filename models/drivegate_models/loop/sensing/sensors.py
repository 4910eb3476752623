"""What a controller sees of the plant: ideal sensors, the published implementation's, or those of a Hall drive."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.sensing.converters import (
    Converters,
    biased_current,
    converted_current,
    converted_supply,
    exact_converters,
)
from drivegate_models.loop.sensing.encoder import Encoder, encoder_speed, no_encoder, turn_encoder
from drivegate_models.loop.sensing.hall import Hall, hall_speed, no_hall, turn_hall

SPEED: Final = 0
"""Signal that drops out: the measured speed."""
CURRENTS: Final = 1
"""Signal that drops out: the phase currents and the sum of their magnitudes."""
SUPPLY: Final = 2
"""Signal that drops out: the supply voltage."""
FIRST_PHASE: Final = 3
"""Signal that drops out: the current of the first phase alone; the other phases have the numbers after it."""


class Sensors(NamedTuple):
    """Constants of the sensors and what they remember; the arrays are updated in place.

    All kinds of sensors are of this one type, so that one compiled loop serves them.
    """

    ideal: bool
    """Whether they show the plant as it is, but for the errors of single phases."""
    biased: bool
    """Whether gains and offsets count, or the samples of single phases are lost."""
    converters: Converters
    """Through which currents and supply are shown."""
    encoder: Encoder
    """Which gives the speed where there are no Hall switches."""
    hall: Hall
    """Which give speed and angle where there are such switches."""
    dropouts: NDArray[np.float64]
    """Signal, start and end (s) of each dropout, shape (d, 3)."""


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
        converters=exact_converters(gains, offsets),
        encoder=no_encoder(),
        hall=no_hall(),
        dropouts=dropouts,
    )


def real_sensors(
    converters: Converters,
    dropouts: NDArray[np.float64],
    *,
    encoder: Encoder | None = None,
    hall: Hall | None = None,
) -> Sensors:
    """Make sensors with finite steps, errors and noise.

    Parameters
    ----------
    converters : Converters
        Through which currents and supply are shown.
    dropouts : ndarray, shape (d, 3)
        Signal, start and end (s) of each dropout.
    encoder : Encoder, optional
        What gives the speed; the inverter's windows then rest on the true angle.
    hall : Hall, optional
        What gives the speed and the angle instead.

    Returns
    -------
    Sensors
        The sensors.
    """
    return Sensors(
        ideal=False,
        biased=True,
        converters=converters,
        encoder=no_encoder() if encoder is None else encoder,
        hall=no_hall() if hall is None else hall,
        dropouts=dropouts,
    )


def showing_the_plant(sensors: Sensors) -> Sensors:
    """Make sensors on which the inverter's windows rest as before, but that show the plant as it is.

    Parameters
    ----------
    sensors : Sensors
        Any sensors.

    Returns
    -------
    Sensors
        With the same Hall switches, if there are any.
    """
    return ideal_sensors(sensors.converters.gains.size)._replace(hall=sensors.hall)


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
    return hall_speed(sensors.hall) if sensors.hall.present else encoder_speed(sensors.encoder)


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
    return converted_supply(sensors.converters, supply)


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
            current, mean = biased_current(sensors.converters, phase, current, mean)
        if not sensors.ideal:
            current, mean = converted_current(sensors.converters, current, mean)
        shown[phase] = current
        total += mean
    return total


@inlined
def turn_sensors(sensors: Sensors, step: int, time: float, period: float, speed: float) -> float:
    """Let what is on the shaft turn for one control period, and measure the speed at its end.

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

    Returns
    -------
    float
        Mean over the period of the electrical angle that the inverter's windows rest on, less the true one (rad).
    """
    if sensors.hall.present:
        return turn_hall(sensors.hall, time, period, speed)
    if not sensors.ideal:
        turn_encoder(sensors.encoder, step, time, period, speed)
    return 0.0
