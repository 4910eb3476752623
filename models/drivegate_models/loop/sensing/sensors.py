"""The sensors between plant and controller: ideal, those of the published implementation, or Hall switches."""

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
"""Signal that drops out: the current of the first phase alone. The other phases have the numbers after it."""


class Sensors(NamedTuple):
    """Constants and state of the sensors; the arrays are updated in place.

    All kinds of sensors have this one type, so that one compiled loop serves all of them.
    """

    ideal: bool
    """True if measured values are exact, except for errors of single phases."""
    biased: bool
    """True if gains and offsets are used, or samples of single phases are lost."""
    converters: Converters
    """Converters of currents and supply voltage."""
    encoder: Encoder
    """Measures the speed if there are no Hall switches."""
    hall: Hall
    """Hall switches, which measure speed and angle if present."""
    dropouts: NDArray[np.float64]
    """Signal, start and end (s) of each dropout, shape (d, 3)."""


def ideal_sensors(
    phases: int,
    dropouts: NDArray[np.float64] | None = None,
    gains: NDArray[np.float64] | None = None,
    offsets: NDArray[np.float64] | None = None,
) -> Sensors:
    """Return sensors without errors, except for dropouts and the bias of current sensors.

    `phases`: number of phases. `dropouts`, shape (d, 3): signal, start and end (s) of each dropout. `gains`,
    `offsets`, shape (m,): gain (1) and offset (A) of each phase's current sensor. Result: without encoder and Hall
    switches; they measure the true speed.
    """
    dropouts = np.zeros((0, 3)) if dropouts is None else dropouts
    gains = np.ones(phases) if gains is None else gains
    offsets = np.zeros(phases) if offsets is None else offsets
    lost = bool((dropouts[:, 0] >= FIRST_PHASE).any())
    biased = lost or bool((gains != 1.0).any() or (offsets != 0.0).any())
    return real_sensors(exact_converters(gains, offsets), dropouts)._replace(ideal=True, biased=biased)


def real_sensors(
    converters: Converters,
    dropouts: NDArray[np.float64],
    *,
    encoder: Encoder | None = None,
    hall: Hall | None = None,
) -> Sensors:
    """Return sensors with quantization, errors and noise.

    `dropouts`, shape (d, 3): signal, start and end (s) of each dropout. `encoder`: measures the speed; the inverter's
    windows then use the true angle.
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
    """Return ideal sensors that leave the angle of the inverter's windows unchanged.

    Result: ideal, with the same Hall switches, if there are any.
    """
    return ideal_sensors(sensors.converters.gains.size)._replace(hall=sensors.hall)


@inlined
def dropped(dropouts: NDArray[np.float64], signal: int, time: float) -> bool:
    """Return True if a signal is lost at a time.

    `dropouts`, shape (d, 3): signal, start and end (s) of each dropout. `signal`: `SPEED`, `CURRENTS`, `SUPPLY`, or
    `FIRST_PHASE` plus the index of a phase. `time`: time (s). Result: true from the start of a dropout until just
    before its end.
    """
    lost = False
    for row in range(dropouts.shape[0]):
        if dropouts[row, 0] == signal and dropouts[row, 1] <= time < dropouts[row, 2]:
            lost = True
    return lost


@inlined
def shown_speed(sensors: Sensors, time: float, speed: float) -> float:
    """Return the measured speed of the shaft.

    `sensors`: Hall switches take precedence over the encoder. `time`: time (s). `speed`: true speed (rad/s), measured
    by ideal sensors.
    """
    if dropped(sensors.dropouts, SPEED, time):
        return 0.0
    if sensors.ideal:
        return speed
    return hall_speed(sensors.hall) if sensors.hall.present else encoder_speed(sensors.encoder)


@inlined
def shown_supply(sensors: Sensors, time: float, supply: float) -> float:
    """Return the measured voltage of a half-source.

    `time`: time (s). `supply`: mean voltage of the half-sources (V).
    """
    if dropped(sensors.dropouts, SUPPLY, time):
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

    The sensor's filter averages each phase's magnitude over the period just ended. An offset is added with the sign of
    the current.

    - `time`: time (s).
    - `currents`, shape (m,): true currents (A).
    - `magnitudes`, shape (m,): integrals of their magnitudes over the period just ended (A s).
    - `period`: length of that period (s).
    - `shown`, shape (m,) or longer: receives the measured currents (A).
    - Result: measured sum of the magnitudes (A).
    """
    total = 0.0
    lost = dropped(sensors.dropouts, CURRENTS, time)
    for phase in range(currents.size):
        if lost or dropped(sensors.dropouts, FIRST_PHASE + phase, time):
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
    """Advance the sensors on the shaft by one control period, and measure the speed at its end.

    - `step`: number of the control period, from 0.
    - `time`: start of the period (s).
    - `period`: length of the period (s).
    - `speed`: true speed of the shaft (rad/s).
    - Result: mean over the period of the angle used by the inverter's windows, minus the true one (rad electrical).
    """
    if sensors.hall.present:
        return turn_hall(sensors.hall, time, period, speed)
    if not sensors.ideal:
        turn_encoder(sensors.encoder, step, time, period, speed)
    return 0.0
