"""Sensors of a duty-ratio controller: currents by shunts, link voltage by a converter, position of the shaft.

Currents are sampled at the start of a control period. If a shunt carries a phase's current only while a switch is on,
the switch must have been on for the settling time of amplifier and converter before that instant. A phase that is not
measured is computed from the other two. If two are not measured, their last values are used.
"""

from __future__ import annotations

from math import nan
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
from drivegate_models.loop.sensing.sensors import CURRENTS, FIRST_PHASE, SPEED, SUPPLY, dropped
from drivegate_models.loop.shaft import shown_angle
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.sine import cosine_sine, small_argument
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
NONE: Final = 3
"""Nothing measures angle and speed, which are NaN."""


class Shunts(NamedTuple):
    """Current measurement by shunts."""

    kind: int
    """`IN_LINE`, `LOW_SIDE` or `DC_LINK`."""
    window: float
    """Minimum time for which a current must have flowed through a shunt before sampling (s)."""
    shown: NDArray[np.float64]
    """Last measured currents, shape (3,) (A)."""


class ShaftErrors(NamedTuple):
    """Errors of a sensor with one sine and one cosine track a turn, as a resolver or a magnet at the shaft's end."""

    present: bool
    eccentricity: float
    """Amplitude of the angle's error by an eccentric sensor (rad of the shaft)."""
    eccentric_from: float
    """Angle of the shaft at which that error is 0 and rises (rad)."""
    sine_offset: float
    cosine_offset: float
    """Offsets of the tracks over their amplitude (1)."""
    gain: float
    """Amplitude of the sine track over that of the cosine track, less 1 (1)."""
    phase: float
    """Angle by which the tracks are closer together than a right angle (rad)."""
    latency: float
    """Age of what is shown (s)."""
    past: NDArray[np.float64]
    """Angle (rad) and speed (rad/s) of the shaft at the last samples, a ring buffer, shape (n, 2); `empty_past`."""


def empty_past(latency: float, period: float) -> NDArray[np.float64]:
    """Return work space for what the shaft did within a latency (s), for a control period (s)."""
    return np.zeros((int(latency / period) + 2, 2))


def no_shaft_errors() -> ShaftErrors:
    """Return the errors of a sensor without any."""
    return ShaftErrors(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.zeros((2, 2)))


class DutySensors(NamedTuple):
    """Constants and state of the sensors; the arrays are updated in place."""

    ideal: bool
    """True if measured values are exact."""
    converters: Converters
    """Gains, offsets, noise, steps and ranges; the voltage is that of the whole link."""
    shunts: Shunts
    position: int
    """`EXACT`, `ENCODER`, `HALL` or `NONE`."""
    encoder: Encoder
    """The encoder; its count is zero at angle zero."""
    hall: Hall
    errors: ShaftErrors
    """Errors of angle and speed if `position` is `EXACT`."""
    dropouts: NDArray[np.float64]
    """Signal, start and end (s) of each dropout, shape (d, 3), with the signals of `loop.sensing.sensors`."""


def ideal_duty_sensors(dropouts: NDArray[np.float64] | None = None) -> DutySensors:
    """Return sensors that measure exact values at all times, except during dropouts."""
    exact = exact_converters(np.ones(3), np.zeros(3))
    return real_duty_sensors(exact, dropouts=dropouts)._replace(ideal=True)


def real_duty_sensors(
    converters: Converters,
    *,
    shunt: int = IN_LINE,
    window: float = 0.0,
    encoder: Encoder | None = None,
    hall: Hall | None = None,
    errors: ShaftErrors | None = None,
    has_position: bool = True,
    dropouts: NDArray[np.float64] | None = None,
) -> DutySensors:
    """Return sensors with errors.

    `shunt`: `IN_LINE`, `LOW_SIDE` or `DC_LINK`. `window`: minimum time for which a current must have flowed through a
    shunt before sampling (s). `errors`: errors of angle and speed without encoder and Hall switches; none by default.
    `has_position`: false if nothing measures angle and speed. `dropouts`, shape (d, 3): signal, start and end (s) of
    each dropout.
    """
    position = (
        HALL if hall is not None else ENCODER if encoder is not None else EXACT if has_position else NONE
    )
    return DutySensors(
        False,
        converters,
        Shunts(int(shunt), float(window), np.zeros(3)),
        position,
        no_encoder() if encoder is None else encoder,
        no_hall() if hall is None else hall,
        no_shaft_errors() if errors is None else errors,
        np.zeros((0, 3)) if dropouts is None else dropouts,
    )


def delayed_glitches(sensors: DutySensors, delay: float) -> DutySensors:
    """Return sensors whose false edges come later by a delay (s)."""
    later = sensors.encoder.glitches + np.array([delay, 0.0])
    return sensors._replace(encoder=sensors.encoder._replace(glitches=later))


@inlined
def low_time(alignment: int, ratio: float, period: float) -> float:
    """Return the time for which the lower switch has been on at the end of a control period.

    `alignment`: `drive.CENTRED`, `RISING` or `FALLING`. `ratio`: duty ratio in the period (1). `period`: length of the
    period (s). Result: time without interruption (s), at most the period.
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

    `currents`, shape (3,): true currents (A), replaced. `alignment`: alignment of the period just ended:
    `drive.CENTRED`, `RISING` or `FALLING`. `ratios`, shape (3,): duty ratios in that period (1). `period`: length of
    that period (s).
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
def show_currents_of_idle_bridge(sensors: DutySensors, currents: NDArray[np.float64]) -> None:
    """Replace the phase currents (A), shape (3,), by their measured values while all legs are off.

    That is before a run, and after a restart. Every shunt counts as measurable: without current each shows the offset
    of its amplifier.
    """
    shown = sensors.shunts.shown
    for leg in range(3):
        shown[leg] = shown_current(sensors.converters, leg, currents[leg])
        currents[leg] = shown[leg]


@inlined
def _aged(errors: ShaftErrors, step: int, period: float, sense: Any) -> tuple[float, float]:
    """Store angle and speed of a Sense, and return those of a latency ago (rad, rad/s).

    Within a control period the plant's angle turns at constant speed, and its speed changes at a constant rate. Before
    the first sample, the shaft has turned at constant speed.
    """
    past = errors.past
    size = past.shape[0]
    past[step % size, 0] = sense.angle
    past[step % size, 1] = sense.speed
    whole = int(errors.latency / period)
    newer = step - whole
    if newer <= 0:
        angle, speed = past[0, 0], past[0, 1]
        return float(angle - speed * (errors.latency - step * period)), float(speed)
    share = errors.latency / period - whole
    angle, speed = past[newer % size, 0], past[newer % size, 1]
    before, speed_before = past[(newer - 1) % size, 0], past[(newer - 1) % size, 1]
    return float(angle - share * within_half_turn(angle - before)), float(
        speed - share * (speed - speed_before)
    )


@inlined
def _track_error(errors: ShaftErrors, cosine: float, sine: float) -> tuple[float, float]:
    """Return the error of the angle of two tracks (rad), and the slope of the error over the angle (1).

    `cosine`, `sine`: those of the true angle. The tracks are ``C = cos x + o_c`` and
    ``S = (1 + g) sin(x + d) + o_s``. With ``C + iS = a exp(ix) + b exp(-ix) + o``, the error without the alignment is
    the argument of ``(C + iS) exp(-ix) conj(a)``, where ``2 a = 1 + (1 + g) exp(id)``. Its mean over a turn is 0.
    """
    amplitude = 1.0 + errors.gain
    phase_cosine, phase_sine = cosine_sine(errors.phase)
    ahead_cosine = cosine * phase_cosine - sine * phase_sine
    ahead_sine = sine * phase_cosine + cosine * phase_sine
    across = amplitude * ahead_sine + errors.sine_offset
    along = cosine + errors.cosine_offset
    real = along * cosine + across * sine
    imaginary = across * cosine - along * sine
    main_real, main_imaginary = 1.0 + amplitude * phase_cosine, amplitude * phase_sine
    error = small_argument(
        real * main_real + imaginary * main_imaginary, imaginary * main_real - real * main_imaginary
    )
    turned = along * amplitude * ahead_cosine + across * sine
    return error, turned / (along * along + across * across) - 1.0


@inlined
def _show_erroneous(errors: ShaftErrors, step: int, period: float, sense: Any) -> None:
    """Replace angle and speed in a Sense by those of a sensor with errors; the speed is the angle's derivative."""
    angle, speed = sense.angle, sense.speed
    if errors.latency > 0.0:
        angle, speed = _aged(errors, step, period, sense)
    cosine, sine = cosine_sine(angle)
    around, turned = cosine_sine(angle - errors.eccentric_from)
    error, slope = _track_error(errors, cosine, sine)
    sense.angle = shown_angle(angle + (error + errors.eccentricity * turned))
    sense.speed = speed * (1.0 + (slope + errors.eccentricity * around))


@inlined
def drop_signals(sensors: DutySensors, time: float, currents: NDArray[np.float64], sense: Any) -> None:
    """Replace the signals in a Sense that are lost at a time (s) by 0, as loose contacts do."""
    if sensors.dropouts.shape[0] == 0:
        return
    if sensors.position != NONE and dropped(sensors.dropouts, SPEED, time):
        sense.speed = 0.0
    if dropped(sensors.dropouts, SUPPLY, time):
        sense.supply_voltage = 0.0
    every = dropped(sensors.dropouts, CURRENTS, time)
    for leg in range(3):
        if every or dropped(sensors.dropouts, FIRST_PHASE + leg, time):
            currents[leg] = 0.0


@inlined
def show_shaft(sensors: DutySensors, sense: Any, step: int, period: float) -> None:
    """Replace link voltage, angle and speed in a Sense by their measured values.

    `step`: number of the control period since the shaft began to turn. `period`: length of a control period (s).
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
        sense.angle = shown_angle(hall_shaft_angle(sensors.hall, step * period))
        sense.speed = hall_speed(sensors.hall)
    elif sensors.position == NONE:
        sense.angle = nan
        sense.speed = nan
    elif sensors.errors.present:
        _show_erroneous(sensors.errors, step, period, sense)


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
