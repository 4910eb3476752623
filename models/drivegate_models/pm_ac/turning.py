"""Control periods before a run in which a held shaft turns, so that a controller counts its turns.

The exact plant would take minutes for them. The currents here follow the mean voltages of the command, so that a
controller that compares fluxes, or that wants a d current without a torque, sees a machine. Angle, currents and sensors
have a state of their own: the run itself begins bit for bit as without these turns.
"""

from __future__ import annotations

from math import isnan, pi
from typing import Any, Final, NamedTuple

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.exchange import COMPLETED, STOPPED, Exchange
from drivegate_models.loop.shaft import shown_angle, whole_turns, within_a_turn
from drivegate_models.machine.rotor_frame import RotorFrame, from_phases, of_phase, phase_current
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.exchange import write_sense
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.sensing import (
    DutySensors,
    ideal_duty_sensors,
    low_side_ratio,
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
def _write_induced(voltages: Any, drive: PmAcDrive, angle: float, speed: float) -> None:
    """Write the voltages of the terminals at an electrical angle (rad) and a speed of the shaft (rad/s)."""
    cosine, sine = cosine_sine(angle)
    induced = RotorFrame(0.0, drive.pole_pairs * speed * drive.magnet_flux, cosine, sine)
    lowest = min(phase_current(induced, 0), phase_current(induced, 1), phase_current(induced, 2))
    for leg in range(3):
        voltages[leg] = phase_current(induced, leg) - lowest - drive.diode_drop


@inlined
def _write_means(
    voltages: Any,
    drive: PmAcDrive,
    acting: tuple[bool, float, float],
    link: float,
    angle: float,
    speed: float,
) -> None:
    """Write the means of a control period: of the command about half the link, or of the EMF in its middle.

    `acting`: whether the bridge is on, and its mean voltage in the stationary frame (V). `angle`: in the middle of the
    period (rad).
    """
    is_on, along, across = acting
    if not is_on:
        _write_induced(voltages, drive, angle, speed)
        return
    for leg in range(3):
        voltages[leg] = 0.5 * link + of_phase(leg, along, across)


@inlined
def _within(ratio: float) -> float:
    return min(max(ratio, 0.0), 1.0)


@inlined
def _mean_voltage(exchange: Exchange, link: float) -> tuple[bool, float, float]:
    """Return whether all legs of a command switch, and its mean voltage in the stationary frame (V)."""
    command = exchange.command[0]
    is_on = command.first_leg != LEG_OFF and command.second_leg != LEG_OFF and command.third_leg != LEG_OFF
    first = low_side_ratio(command.first_duty, command.first_leg)
    second = low_side_ratio(command.second_duty, command.second_leg)
    third = low_side_ratio(command.third_duty, command.third_leg)
    if isnan(first + second + third):
        return False, 0.0, 0.0
    along, across = from_phases(_within(first), _within(second), _within(third))
    return is_on, link * along, link * across


@inlined
def _currents_after(
    drive: PmAcDrive,
    voltage: tuple[bool, float, float],
    currents: tuple[float, float],
    angle: float,
    speed: float,
    length: float,
) -> tuple[float, float]:
    """Return the d-axis and q-axis currents (A) at the end of a control period, 0 where the bridge is off.

    - `voltage`: whether the bridge is on, and its mean voltage in the stationary frame (V).
    - `currents`: those at its begin (A).
    - `angle`, `speed`: electrical angle in the middle of the period (rad), and electrical speed (rad/s).
    - `length`: length of the period (s).

    By the trapezoidal rule, which is stable for any length: ``L (i - i_0) / T = v - R i_m - j w (L i_m + psi)``, with
    the mean ``i_m`` of both currents.
    """
    is_on, along, across = voltage
    if not is_on:
        return 0.0, 0.0
    cosine, sine = cosine_sine(angle)
    direct_before, quadrature_before = currents
    half = 0.5 * drive.resistance
    direct_rate, quadrature_rate = drive.direct_inductance / length, drive.quadrature_inductance / length
    coupled, coupling = 0.5 * speed * drive.quadrature_inductance, 0.5 * speed * drive.direct_inductance
    driving = (
        cosine * along + sine * across + (direct_rate - half) * direct_before + coupled * quadrature_before
    )
    pushing = cosine * across - sine * along - speed * drive.magnet_flux
    pushing += (quadrature_rate - half) * quadrature_before - coupling * direct_before
    first, second = direct_rate + half, quadrature_rate + half
    determinant = first * second + coupled * coupling
    return (
        (second * driving + coupled * pushing) / determinant,
        (first * pushing - coupling * driving) / determinant,
    )


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
    shows_means: bool,
) -> int:
    """Step a controller while the shaft turns before its run, which begins without a current all the same.

    - `begin`: electrical angle at the start (rad), which whole turns end at again; time of the controller's clock (s).
    - `link`: voltage of the dc link (V).
    - `reference`: reference of speed (rad/s), or of a torque (N m).
    - `length`: length of a control period (s).
    - `enable`: what the Sense shows for it.
    - `shows_means`: true if the drive senses the means of the terminals' voltages.
    - Result: `COMPLETED`, or `STOPPED` where the controller has asked for that.
    """
    angle, clock = begin
    turns = 0
    electrical = drive.pole_pairs * turning.speed
    currents = 0.0, 0.0
    acting = False, 0.0, 0.0
    for number in range(turning.periods):
        cosine, sine = cosine_sine(angle)
        frame = RotorFrame(currents[0], currents[1], cosine, sine)
        for leg in range(3):
            exchange.sensed_currents[leg] = phase_current(frame, leg)
        shaft_angle = shown_angle((angle + 2.0 * pi * turns) / drive.pole_pairs)
        time = clock + number * length
        write_sense(exchange, exchange.sensed_currents, link, reference, time, shaft_angle, turning.speed)
        _write_induced(exchange.sense[0].phase_voltages, drive, angle, turning.speed)
        if shows_means and number == 0:
            _write_induced(exchange.sense[0].mean_voltages, drive, angle, turning.speed)
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
        commanded = _mean_voltage(exchange, link)
        acting = acting if drive.modulator.update_delay > 0 else commanded
        currents = _currents_after(
            drive, acting, currents, angle + 0.5 * electrical * length, electrical, length
        )
        if shows_means:
            middle = angle + 0.5 * electrical * length
            _write_means(exchange.sense[0].mean_voltages, drive, acting, link, middle, turning.speed)
        acting = commanded
        turned = angle + electrical * length
        turns = (turns + whole_turns(turned)) % drive.pole_pairs
        angle = within_a_turn(turned)
        if not turning.sensors.ideal:
            turn_shaft_sensors(turning.sensors, number, number * length, length, turning.speed)
    return COMPLETED
