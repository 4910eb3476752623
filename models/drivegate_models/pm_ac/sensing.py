"""Sensors of a duty-ratio controller: currents by shunts, link voltage by a converter, position of the shaft.

Currents are sampled at the start of a control period. If a shunt carries a phase's current only while a switch is on,
the switch must have been on for the settling time of amplifier and converter before that instant. A phase that is not
measured is computed from the other two. If two are not measured, their last values are used.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_PWM
from drivegate_models.loop.sensing.converters import (
    Converters,
    converted_supply,
    exact_converters,
    shown_current,
)
from drivegate_models.loop.sensing.encoder import (
    Encoder,
    count_within_a_turn,
    encoder_speed,
    lose_count,
    no_encoder,
    turn_encoder,
)
from drivegate_models.loop.sensing.hall import (
    Hall,
    hall_bits,
    hall_shaft_angle,
    hall_speed,
    lose_switching,
    no_hall,
    turn_hall,
)
from drivegate_models.loop.shaft import shown_angle
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING

IN_LINE: Final = 0
"""A shunt in each phase, which carries its current at all times."""
LOW_SIDE: Final = 1
"""A shunt below each lower switch, which carries a phase's current while that switch is on."""
DC_LINK: Final = 2
"""One shunt in the link, which carries the currents of the legs with maximum and minimum duty ratio in turn."""

EXACT: Final = 0
"""Angle and speed of the shaft are measured without error."""
ENCODER: Final = 1
"""An encoder counts edges and times them."""
HALL: Final = 2
"""Three Hall switches, whose timer measures angle and speed."""


class Shunts(NamedTuple):
    """Current measurement by shunts."""

    kind: int
    """`IN_LINE`, `LOW_SIDE` or `DC_LINK`."""
    window: float
    """Minimum time for which a current must have flowed through a shunt before sampling (s)."""
    shown: NDArray[np.float64]
    """Last measured currents, shape (3,) (A)."""


class DutySensors(NamedTuple):
    """Constants and state of the sensors; the arrays are updated in place."""

    ideal: bool
    """True if measured values are exact."""
    converters: Converters
    """Gains, offsets, noise, steps and ranges; the voltage is that of the whole link."""
    shunts: Shunts
    position: int
    """`EXACT`, `ENCODER` or `HALL`."""
    encoder: Encoder
    """The encoder; its count is zero at angle zero."""
    hall: Hall


def ideal_duty_sensors() -> DutySensors:
    """Return sensors that measure exact values at all times."""
    return DutySensors(
        True,
        exact_converters(np.ones(3), np.zeros(3)),
        Shunts(IN_LINE, 0.0, np.zeros(3)),
        EXACT,
        no_encoder(),
        no_hall(),
    )


def real_duty_sensors(
    converters: Converters,
    *,
    shunt: int = IN_LINE,
    window: float = 0.0,
    encoder: Encoder | None = None,
    hall: Hall | None = None,
) -> DutySensors:
    """Return sensors with errors.

    Parameters
    ----------
    converters : Converters
        Converters of currents and link voltage.
    shunt : int
        `IN_LINE`, `LOW_SIDE` or `DC_LINK`.
    window : float
        Minimum time for which a current must have flowed through a shunt before sampling (s).
    encoder : Encoder, optional
        Measures angle and speed.
    hall : Hall, optional
        Measures angle and speed instead of an encoder. Without both, they are measured without error.

    Returns
    -------
    DutySensors
        With placeholders for missing sensors.
    """
    position = HALL if hall is not None else ENCODER if encoder is not None else EXACT
    return DutySensors(
        False,
        converters,
        Shunts(int(shunt), float(window), np.zeros(3)),
        position,
        no_encoder() if encoder is None else encoder,
        no_hall() if hall is None else hall,
    )


@inlined
def low_time(alignment: int, ratio: float, period: float) -> float:
    """Return the time for which the lower switch has been on at the end of a control period.

    Parameters
    ----------
    alignment : int
        `drive.CENTRED`, `RISING` or `FALLING`.
    ratio : float
        Duty ratio in the period (1).
    period : float
        Length of the period (s).

    Returns
    -------
    float
        Time without interruption (s), at most the period.
    """
    off = (1.0 - min(max(ratio, 0.0), 1.0)) * period
    if off >= period:
        return period
    if alignment == CENTRED:
        return 0.5 * off
    return off if alignment == FALLING else 0.0


@inlined
def low_side_ratio(ratio: float, mode: int) -> float:
    """Return the share of a period in which a leg's lower switch is not on: 1 for a high leg, or for an off leg."""
    if mode == LEG_PWM:
        return ratio
    return 0.0 if mode == LEG_LOW else 1.0


@inlined
def _is_measurable(
    shunts: Shunts, alignment: int, ratios: NDArray[np.float64], leg: int, period: float
) -> bool:
    """Return True if a phase's current can be measured at the end of a control period."""
    if shunts.kind == IN_LINE:
        return True
    if shunts.kind == LOW_SIDE:
        return low_time(alignment, ratios[leg], period) >= shunts.window
    # The link carries one leg's current alone while its switch is the only one on its rail, in each half of a pulse.
    greatest = max(ratios[(leg + 1) % 3], ratios[(leg + 2) % 3])
    least = min(ratios[(leg + 1) % 3], ratios[(leg + 2) % 3])
    alone = max(ratios[leg] - greatest, least - ratios[leg]) * period
    return bool((0.5 * alone if alignment == CENTRED else alone) >= shunts.window)


@unallocating
def show_phase_currents(
    sensors: DutySensors,
    currents: NDArray[np.float64],
    alignment: int,
    ratios: NDArray[np.float64],
    period: float,
) -> None:
    """Replace the phase currents at the end of a control period by their measured values.

    Parameters
    ----------
    sensors : DutySensors
        Their noise and their last measured currents are updated.
    currents : ndarray, shape (3,)
        True currents (A), replaced.
    alignment : int
        Alignment of the period just ended: `drive.CENTRED`, `RISING` or `FALLING`.
    ratios : ndarray, shape (3,)
        Duty ratios in that period (1).
    period : float
        Length of that period (s).
    """
    shown = sensors.shunts.shown
    missing_count = 0
    missing = 0
    for leg in range(3):
        if _is_measurable(sensors.shunts, alignment, ratios, leg, period):
            shown[leg] = shown_current(sensors.converters, leg, currents[leg])
        else:
            missing_count += 1
            missing = leg
    if missing_count == 1:
        shown[missing] = -shown[(missing + 1) % 3] - shown[(missing + 2) % 3]
    for leg in range(3):
        currents[leg] = shown[leg]


@inlined
def show_shaft(sensors: DutySensors, sense: Any, now: float) -> None:
    """Replace link voltage, angle and speed in a Sense by their measured values.

    Parameters
    ----------
    sensors : DutySensors
        The state of their noise is updated.
    sense : record of DUTY_SENSE
        With true values, replaced.
    now : float
        Time since the start of the run, for the timer of Hall edges (s).
    """
    sense.supply_voltage = converted_supply(sensors.converters, sense.supply_voltage)
    if sensors.position == ENCODER:
        count = count_within_a_turn(sensors.encoder)
        sense.encoder_count = count
        # The middle between the two adjacent edges.
        sense.angle = shown_angle((count + 0.5) * sensors.encoder.edge_angle)
        sense.speed = encoder_speed(sensors.encoder)
    elif sensors.position == HALL:
        sense.hall = hall_bits(sensors.hall)
        sense.angle = shown_angle(hall_shaft_angle(sensors.hall, now))
        sense.speed = hall_speed(sensors.hall)


@inlined
def lose_next_edge(sensors: DutySensors) -> None:
    """Skip the next edge of the sensor on the shaft."""
    if sensors.position == ENCODER:
        lose_count(sensors.encoder)
    elif sensors.position == HALL:
        lose_switching(sensors.hall)


@inlined
def turn_shaft_sensors(sensors: DutySensors, step: int, time: float, period: float, speed: float) -> None:
    """Advance the sensor on the shaft by a control period at a speed (rad/s)."""
    if sensors.position == ENCODER:
        turn_encoder(sensors.encoder, step, time, period, speed)
    elif sensors.position == HALL:
        turn_hall(sensors.hall, time, period, speed)
