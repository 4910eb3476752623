"""What a controller of duty ratios sees: currents through shunts, the link through a converter, the shaft's position.

Currents are those at the start of a control period. Where a shunt sees a phase only while a switch is on, it must have
been so for a while before that instant: the window in which amplifier and converter settle. A phase that is not seen
is what the other two leave, and where two are not seen the last one that was goes on.
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
"""A shunt in each phase, which sees its current at all times."""
LOW_SIDE: Final = 1
"""A shunt below each lower switch, which sees a phase's current while that switch is on."""
DC_LINK: Final = 2
"""One shunt in the link: it sees the leg of the greatest and that of the least duty ratio, each in its own interval."""

EXACT: Final = 0
"""Angle and speed of the shaft are shown as they are."""
ENCODER: Final = 1
"""An encoder counts edges and times them."""
HALL: Final = 2
"""Three Hall switches, whose timer measures angle and speed."""


class Shunts(NamedTuple):
    """Through what currents are seen."""

    kind: int
    """`IN_LINE`, `LOW_SIDE` or `DC_LINK`."""
    window: float
    """How long a current must have flowed through a shunt to be seen (s)."""
    shown: NDArray[np.float64]
    """Currents shown last, shape (3,) (A)."""


class DutySensors(NamedTuple):
    """Constants of the sensors and what they remember; the arrays are updated in place."""

    ideal: bool
    """Whether they show the plant as it is."""
    converters: Converters
    """Gains, offsets, noise, steps and ranges; the voltage is that of the whole link."""
    shunts: Shunts
    position: int
    """`EXACT`, `ENCODER` or `HALL`."""
    encoder: Encoder
    """Its count is zero where the angle that it shows is zero."""
    hall: Hall


def ideal_duty_sensors() -> DutySensors:
    """Make sensors that show the plant as it is.

    Returns
    -------
    DutySensors
        The sensors.
    """
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
    """Make sensors with errors.

    Parameters
    ----------
    converters : Converters
        Through which currents and link are shown.
    shunt : int
        `IN_LINE`, `LOW_SIDE` or `DC_LINK`.
    window : float
        How long a current must have flowed through a shunt to be seen (s).
    encoder : Encoder, optional
        What gives angle and speed.
    hall : Hall, optional
        What gives them instead; without both they are shown as they are.

    Returns
    -------
    DutySensors
        The sensors.
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
    """Return how long before the end of a control period the lower switch has been on without a break.

    Parameters
    ----------
    alignment : int
        `drive.CENTRED`, `RISING` or `FALLING`.
    ratio : float
        Duty ratio in it (1).
    period : float
        Its length (s).

    Returns
    -------
    float
        (s).
    """
    off = (1.0 - min(max(ratio, 0.0), 1.0)) * period
    if off >= period:
        return period
    if alignment == CENTRED:
        return 0.5 * off
    return off if alignment == FALLING else 0.0


@inlined
def low_side_ratio(ratio: float, mode: int) -> float:
    """Return the share of a period in which a leg's lower switch is not on: 1 for a leg that is high, or off."""
    if mode == LEG_PWM:
        return ratio
    return 0.0 if mode == LEG_LOW else 1.0


@inlined
def _is_seen(shunts: Shunts, alignment: int, ratios: NDArray[np.float64], leg: int, period: float) -> bool:
    """Return whether a phase's current has been seen in a control period."""
    if shunts.kind == IN_LINE:
        return True
    if shunts.kind == LOW_SIDE:
        return low_time(alignment, ratios[leg], period) >= shunts.window
    # The link carries one leg's current alone while its switch is the only one of its rail, in each half of a pulse.
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
    """Replace the phase currents at the end of a control period by what is seen of them.

    Parameters
    ----------
    sensors : DutySensors
        The sensors; their noise goes on.
    currents : ndarray, shape (3,)
        True currents (A), replaced.
    alignment : int
        Of the period just ended.
    ratios : ndarray, shape (3,)
        Duty ratios in it (1).
    period : float
        Its length (s).
    """
    shown = sensors.shunts.shown
    unseen = 0
    which = 0
    for leg in range(3):
        if _is_seen(sensors.shunts, alignment, ratios, leg, period):
            shown[leg] = shown_current(sensors.converters, leg, currents[leg])
        else:
            unseen += 1
            which = leg
    if unseen == 1:
        shown[which] = -shown[(which + 1) % 3] - shown[(which + 2) % 3]
    for leg in range(3):
        currents[leg] = shown[leg]


@inlined
def show_shaft(sensors: DutySensors, sense: Any, now: float) -> None:
    """Replace link voltage, angle and speed in a Sense by what is seen of them.

    Parameters
    ----------
    sensors : DutySensors
        The sensors; their noise goes on.
    sense : record of DUTY_SENSE
        With true values, replaced.
    now : float
        Time since the run began, by which the timer of Hall edges runs (s).
    """
    sense.supply_voltage = converted_supply(sensors.converters, sense.supply_voltage)
    if sensors.position == ENCODER:
        count = count_within_a_turn(sensors.encoder)
        sense.encoder_count = count
        # The middle between the two edges that it can be.
        sense.angle = shown_angle((count + 0.5) * sensors.encoder.edge_angle)
        sense.speed = encoder_speed(sensors.encoder)
    elif sensors.position == HALL:
        sense.hall = hall_bits(sensors.hall)
        sense.angle = shown_angle(hall_shaft_angle(sensors.hall, now))
        sense.speed = hall_speed(sensors.hall)


@inlined
def lose_next_edge(sensors: DutySensors) -> None:
    """Let the next edge of what is on the shaft not come."""
    if sensors.position == ENCODER:
        lose_count(sensors.encoder)
    elif sensors.position == HALL:
        lose_switching(sensors.hall)


@inlined
def turn_shaft_sensors(sensors: DutySensors, step: int, time: float, period: float, speed: float) -> None:
    """Let what is on the shaft turn for a control period, at a speed (rad/s)."""
    if sensors.position == ENCODER:
        turn_encoder(sensors.encoder, step, time, period, speed)
    elif sensors.position == HALL:
        turn_hall(sensors.hall, time, period, speed)
