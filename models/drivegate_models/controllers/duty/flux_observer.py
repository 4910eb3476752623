"""Observer of angle and speed by the stator flux, for a machine without a position sensor.

After Hinkkanen, Saarakkala, Awan, Molsa and Tuovinen, "Observers for sensorless synchronous motor drives: framework for
design and analysis", IEEE Transactions on Industry Applications 54(6), 2018. The voltage drives the flux linkage in the
stationary frame. With the flux of the currents ``psi(i)``, the observed one ``psi'``, their difference
``e = psi(i) - psi'`` in the observed rotor frame and ``a = psi + (L_d - L_q) conj(i)``, the part of e along a corrects
the flux, and the part across it the angle: ``-Im(e / a)`` is the error of the angle.
"""

from __future__ import annotations

from math import isnan, pi
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import from_phases
from drivegate_models.machine.sine import cosine_sine, small_argument

SPEED_GAIN: Final = 0.1
"""Gain of the flux over the electrical speed (1)."""
# Bandwidth of the phase-locked loop (rad/s), and gain of the flux at standstill over the mean of R / L (1). A greater
# gain turns an error of resistance or flux into one of the angle, a smaller one damps its swing too little.
_BANDWIDTH: Final = 2.0 * pi * 50.0
_STILL_GAIN: Final = 0.4


@inlined
def reset_flux_observer(state: Any, nameplate: Any) -> None:
    """Write the constants, for a machine at rest."""
    state.bandwidth = min(_BANDWIDTH, 0.05 / nameplate.control_period)
    inverse = 1.0 / nameplate.direct_inductance + 1.0 / nameplate.quadrature_inductance
    # Where it is above the least speed, a magnet that is off turns the angle too far.
    state.still_gain = min(0.5 * _STILL_GAIN * nameplate.resistance * inverse, state.least_speed)
    state.along_before = 0.0
    state.across_before = 0.0
    state.along_terminal = 0.0
    state.across_terminal = 0.0
    place_rotor(state, 0.0, 0.0, 0.0, 0.0)


@inlined
def argument(along: float, across: float) -> float:
    """Return the angle of a vector that is not zero, within half a turn (rad)."""
    if along >= abs(across):
        return small_argument(along, across)
    if across >= abs(along):
        return 0.5 * pi + small_argument(across, -along)
    if -across >= abs(along):
        return small_argument(-across, along) - 0.5 * pi
    return within_half_turn(pi + small_argument(-along, -across))


@inlined
def place_rotor(state: Any, angle: float, speed: float, along: float, across: float) -> None:
    """Set angle (rad), electrical speed (rad/s), and the flux of currents in the stationary frame (A)."""
    machine = state.machine
    state.angle = within_half_turn(angle)
    state.speed = speed
    state.flux_error = 0.0
    cosine, sine = cosine_sine(state.angle)
    direct = machine.direct_inductance * (cosine * along + sine * across) + machine.magnet_flux
    quadrature = machine.quadrature_inductance * (cosine * across - sine * along)
    state.along_flux = cosine * direct - sine * quadrature
    state.across_flux = sine * direct + cosine * quadrature


@inlined
def acted_voltage(state: Any, sense: Any) -> tuple[float, float]:
    """Return the voltage that acted in the period just ended, in the stationary frame (V).

    It is the command's, which dead time and drops are compensated for. While the legs are off it is the mean of the
    terminals' at both ends.
    """
    machine = state.machine
    voltages = sense.phase_voltages
    along, across = from_phases(voltages[0], voltages[1], voltages[2])
    mean, across_mean = 0.5 * (along + state.along_terminal), 0.5 * (across + state.across_terminal)
    state.along_terminal, state.across_terminal = along, across
    commanded = machine.along_voltage[machine.delay]
    if isnan(commanded):
        return mean, across_mean
    return commanded, machine.across_voltage[machine.delay]


@inlined
def observe_rotor(state: Any, along: float, across: float, voltage: tuple[float, float]) -> None:
    """Advance the observer by a control period, to currents (A) after a voltage in the stationary frame (V)."""
    machine = state.machine
    period, resistance = machine.control_period, machine.resistance
    state.along_flux += period * (voltage[0] - 0.5 * resistance * (along + state.along_before))
    state.across_flux += period * (voltage[1] - 0.5 * resistance * (across + state.across_before))
    angle = state.angle + period * state.speed
    cosine, sine = cosine_sine(angle)
    direct, quadrature = cosine * along + sine * across, cosine * across - sine * along
    missed = machine.direct_inductance * direct + machine.magnet_flux
    missed -= cosine * state.along_flux + sine * state.across_flux
    across_missed = machine.quadrature_inductance * quadrature
    across_missed -= cosine * state.across_flux - sine * state.along_flux
    saliency = machine.direct_inductance - machine.quadrature_inductance
    active, across_active = machine.magnet_flux + saliency * direct, -saliency * quadrature
    square = active * active + across_active * across_active
    state.flux_error = (missed * active + across_missed * across_active) / square
    error = (missed * across_active - across_missed * active) / square
    share = 2.0 * period * (state.still_gain + SPEED_GAIN * abs(state.speed)) * state.flux_error
    corrected, across_corrected = share * active, share * across_active
    state.along_flux += cosine * corrected - sine * across_corrected
    state.across_flux += sine * corrected + cosine * across_corrected
    state.speed += period * state.bandwidth * state.bandwidth * error
    state.angle = within_half_turn(angle + 2.0 * period * state.bandwidth * error)
