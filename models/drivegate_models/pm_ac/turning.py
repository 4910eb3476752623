"""Control periods before a run in which the shaft turns without current, so that a controller counts its turns.

The plant is not part of them: without a current, a held shaft shows an angle, a speed and a back-EMF alone. Angle and
sensors have a state of their own here, so that the run itself begins bit for bit as without these turns.
"""

from __future__ import annotations

from math import pi
from typing import Final, NamedTuple

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.loop.exchange import COMPLETED, STOPPED, Exchange
from drivegate_models.loop.shaft import shown_angle, whole_turns, within_a_turn
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.exchange import write_sense
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.sensing import (
    DutySensors,
    ideal_duty_sensors,
    show_currents_of_idle_bridge,
    show_shaft,
    turn_shaft_sensors,
)

# Periods after which a monitor sees progress, as a power of two: few enough for the slowest controllers.
_SHOWN_AFTER: Final = 10


class Turning(NamedTuple):
    """Control periods in which the shaft turns before a run."""

    periods: int
    """Their number; 0 for none."""
    speed: float
    """Speed of the shaft (rad/s)."""
    sensors: DutySensors
    """Sensors of their own."""


def no_turning() -> Turning:
    """Return that the shaft has not turned."""
    return Turning(0, 0.0, ideal_duty_sensors())


@inlined
def _write_induced(exchange: Exchange, drive: PmAcDrive, angle: float, speed: float) -> None:
    """Write the voltages of the terminals at an electrical angle (rad) and a speed of the shaft (rad/s)."""
    cosine, sine = cosine_sine(angle)
    induced = RotorFrame(0.0, drive.pole_pairs * speed * drive.magnet_flux, cosine, sine)
    lowest = min(phase_current(induced, 0), phase_current(induced, 1), phase_current(induced, 2))
    for leg in range(3):
        exchange.sense[0].phase_voltages[leg] = phase_current(induced, leg) - lowest - drive.diode_drop


@unallocating
def turn_before_run(
    drive: PmAcDrive,
    exchange: Exchange,
    turning: Turning,
    begin: tuple[float, float],
    link: float,
    reference: float,
    length: float,
    enable: int,
) -> int:
    """Step a controller while the shaft turns before its run; whatever it answers has no effect.

    - `begin`: electrical angle at the start (rad), which whole turns end at again; time of the controller's clock (s).
    - `link`: voltage of the dc link (V).
    - `reference`: reference of speed (rad/s), or of a torque (N m).
    - `length`: length of a control period (s).
    - `enable`: what the Sense shows for it.
    - Result: `COMPLETED`, or `STOPPED` where the controller has asked for that.
    """
    angle, clock = begin
    turns = 0
    for number in range(turning.periods):
        for leg in range(3):
            exchange.sensed_currents[leg] = 0.0
        shaft_angle = shown_angle((angle + 2.0 * pi * turns) / drive.pole_pairs)
        time = clock + number * length
        write_sense(exchange, exchange.sensed_currents, link, reference, time, shaft_angle, turning.speed)
        _write_induced(exchange, drive, angle, turning.speed)
        if not turning.sensors.ideal:
            show_currents_of_idle_bridge(turning.sensors, exchange.sensed_currents)
            show_shaft(turning.sensors, exchange.sense[0], number, length)
        exchange.sense[0].enable = enable
        exchange.command[0] = exchange.fresh[0]
        # Never more than the first step, which no monitor takes for the pace of the run.
        exchange.progress[0] = (number >> _SHOWN_AFTER) & 1
        call_step(
            exchange.step_address, exchange.state_address, exchange.sense_address, exchange.command_address
        )
        if exchange.command[0].struct_size < 0:
            return STOPPED
        turned = angle + drive.pole_pairs * turning.speed * length
        turns = (turns + whole_turns(turned)) % drive.pole_pairs
        angle = within_a_turn(turned)
        if not turning.sensors.ideal:
            turn_shaft_sensors(turning.sensors, number, number * length, length, turning.speed)
    return COMPLETED
