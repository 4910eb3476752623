"""Regulation of torque and stator flux magnitude, in the frame of the flux, without current regulators."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_reference import torque_per_quadrature
from drivegate_models.controllers.duty.current_regulator import (
    BANDWIDTH,
    limited_voltage,
    voltage_limit,
    write_voltage,
)
from drivegate_models.machine.sine import cosine_sine

# Lower limit for the slope of torque over load angle as a divisor, relative to the slope of the magnet alone: near
# pull-out torque the slope approaches zero.
_LEAST_SLOPE: Final = 0.3
# Minimum flux with a direction, relative to the magnet's.
_LEAST_FLUX: Final = 1e-3
# Share of the distance to the reference in a control period.
_SHARE: Final = 0.25


@inlined
def reset_torque_regulation(state: Any) -> None:
    """Reset the filtered reference currents."""
    for before in range(3):
        state.direct_way[before] = 0.0
        state.quadrature_way[before] = 0.0


@inlined
def _filter_reference(history: Any, reference: float) -> None:
    """Move a filtered current toward its reference (A) by a share of the distance, and shift its history."""
    history[2] = history[1]
    history[1] = history[0]
    history[0] += _SHARE * (reference - history[0])


@inlined
def _slopes(state: Any, flux: float, along: float, across: float) -> tuple[float, float]:
    """Return the partial derivatives of torque over load angle (N m/rad) and over flux (N m/(V s)).

    `flux` is the magnitude of the stator flux linkage (V s). `along` and `across` are the cosine and sine of the
    load angle, measured from the d axis. They derive from ``T = k (x i_q - y i_d)`` with ``x = F cos d``, ``y = F
    sin d``, ``i_d = (x - psi) / L_d`` and ``i_q = y / L_q``, where k is 1.5 times the pole pairs.
    """
    constant = 1.5 * state.pole_pairs
    saliency = 1.0 / state.quadrature_inductance - 1.0 / state.direct_inductance
    magnet = state.magnet_flux / state.direct_inductance
    angle_slope = flux * (magnet * along + flux * saliency * (along * along - across * across))
    flux_slope = magnet * across + 2.0 * flux * saliency * along * across
    return constant * angle_slope, constant * flux_slope


@inlined
def _limited_to_pull_out(state: Any, flux: float, along: float, across: float, angle: float) -> float:
    """Return the step of the load angle (rad), limited so that it does not exceed the pull-out torque.

    With ``s = L_q - L_d`` the torque of ``F (cos d, sin d)`` is proportional to ``(L_q psi - s F cos d) sin d``. It
    is maximal where ``2 s F cos(d)**2 - L_q psi cos d - s F = 0``, and falls beyond.
    """
    magnet = state.quadrature_inductance * state.magnet_flux
    saliency = (state.quadrature_inductance - state.direct_inductance) * flux
    cosine = -2.0 * saliency / (magnet + sqrt(magnet * magnet + 8.0 * saliency * saliency))
    sine = sqrt(1.0 - cosine * cosine)
    if cosine * along + sine * across > 0.0:
        angle = min(angle, sine * along - cosine * across)
    if cosine * along - sine * across > 0.0:
        angle = max(angle, -sine * along - cosine * across)
    return angle


@inlined
def _flux_errors(
    state: Any, direct: float, quadrature: float, direct_reference: float, quadrature_reference: float
) -> tuple[float, float, float, float]:
    """Return cosine and sine of the load angle, and the flux errors parallel and perpendicular to the flux (V s)."""
    x = state.direct_inductance * direct + state.magnet_flux
    y = state.quadrature_inductance * quadrature
    x_reference = state.direct_inductance * direct_reference + state.magnet_flux
    y_reference = state.quadrature_inductance * quadrature_reference
    flux = max(sqrt(x * x + y * y), _LEAST_FLUX * state.magnet_flux)
    along, across = x / flux, y / flux
    longer = sqrt(x_reference * x_reference + y_reference * y_reference) - flux
    torque = torque_per_quadrature(state, direct) * quadrature
    more = torque_per_quadrature(state, direct_reference) * quadrature_reference - torque
    angle_slope, flux_slope = _slopes(state, flux, along, across)
    least = _LEAST_SLOPE * 1.5 * state.pole_pairs * state.magnet_flux * flux / state.quadrature_inductance
    angle = (more - flux_slope * longer) / max(angle_slope, least)
    return along, across, longer, flux * _limited_to_pull_out(state, flux, along, across, angle)


@inlined
def _feedforward_voltage(state: Any, electrical: float) -> tuple[float, float]:
    """Return the feedforward voltage in the rotor frame that moves the flux of the filtered reference (V)."""
    direct, quadrature = state.direct_way[0], state.quadrature_way[0]
    rate = 1.0 / state.control_period
    along = state.resistance * direct - electrical * state.quadrature_inductance * quadrature
    across = state.resistance * quadrature + electrical * (
        state.direct_inductance * direct + state.magnet_flux
    )
    return (
        along + rate * state.direct_inductance * (direct - state.direct_way[1]),
        across + rate * state.quadrature_inductance * (quadrature - state.quadrature_way[1]),
    )


@inlined
def regulate_torque(
    state: Any,
    sense: Any,
    command: Any,
    direct: float,
    quadrature: float,
    direct_reference: float,
    quadrature_reference: float,
) -> float:
    """Write the duty ratios that move torque and flux to those of the reference currents.

    `direct` and `quadrature` are the measured currents (A), the references are in A, and the integrals are in the
    rotor frame. Return the requested peak phase voltage (V), before the limit.

    The voltage parallel to the stator flux changes its magnitude; the perpendicular one changes the load angle and
    so the torque. Two regulators produce these voltages, applied by space-vector modulation, as in Buja and
    Kazmierkowski, "Direct torque control of PWM inverter-fed AC motors - a survey", IEEE Transactions on Industrial
    Electronics 51(4), 2004. The slopes of the torque decouple them, after Awan, Hinkkanen, Bojoi and Pellegrino,
    "Stator-flux-oriented control of synchronous motors: a systematic design procedure", IEEE Transactions on
    Industry Applications 55(5), 2019. A feedforward voltage moves the flux of the filtered reference.
    """
    electrical = state.pole_pairs * sense.speed
    bandwidth = BANDWIDTH / state.control_period
    _filter_reference(state.direct_way, direct_reference)
    _filter_reference(state.quadrature_way, quadrature_reference)
    # The effect of this step is measured one or two periods later.
    seen = 1 + state.delay
    direct_due, quadrature_due = state.direct_way[seen], state.quadrature_way[seen]
    along, across, longer, turned = _flux_errors(state, direct, quadrature, direct_due, quadrature_due)
    # Integrate in the rotor frame, in which most model errors are constant: a torque step rotates the flux, not them.
    error, across_error = along * longer - across * turned, across * longer + along * turned
    feedforward, across_feedforward = _feedforward_voltage(state, electrical)
    feedforward += bandwidth * error + state.direct_integral
    across_feedforward += bandwidth * across_error + state.quadrature_integral
    # As with the current regulators, the voltage that rotates the flux error is added only as far as the limit allows.
    added = electrical * state.quadrature_inductance * (quadrature_due - quadrature)
    across_added = -electrical * state.direct_inductance * (direct_due - direct)
    applied, across_applied = limited_voltage(
        feedforward, across_feedforward, added, across_added, voltage_limit(state, sense)
    )
    requested, across_requested = feedforward + added, across_feedforward + across_added
    # Anti-windup: the voltage cut by the limit does not enter the integrals.
    error += (applied - requested) / bandwidth
    across_error += (across_applied - across_requested) / bandwidth
    state.direct_integral += state.direct_integral_step / state.direct_inductance * error
    state.quadrature_integral += state.quadrature_integral_step / state.quadrature_inductance * across_error
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.lead)
    voltage, current = (applied, across_applied), (direct_reference, quadrature_reference)
    write_voltage(state, sense, command, ahead, ahead, voltage, current)
    return float(sqrt(requested * requested + across_requested * across_requested))
