"""Torque and magnitude of the stator flux, regulated in the flux's own frame: no current has a regulator."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_reference import torque_per_quadrature
from drivegate_models.controllers.duty.current_regulator import (
    BANDWIDTH,
    give_voltage,
    limited_voltage,
    voltage_limit,
)
from drivegate_models.machine.sine import cosine_sine

# Least slope of the torque over the load angle that is divided by, over that of the magnet alone: where the torque
# is near the greatest that the flux can give, an angle is worth hardly any.
_LEAST_SLOPE: Final = 0.3
# Least flux over the magnet's that has a direction.
_LEAST_FLUX: Final = 1e-3
# Share of the way to the reference in a control period.
_SHARE: Final = 0.25


@inlined
def reset_torque_regulation(state: Any) -> None:
    """Forget the way to the reference."""
    for before in range(3):
        state.direct_way[before] = 0.0
        state.quadrature_way[before] = 0.0


@inlined
def _next_on_way(way: Any, reference: float) -> None:
    """Go on to the reference of a current by a share of what is left, and remember where it was (A)."""
    way[2] = way[1]
    way[1] = way[0]
    way[0] += _SHARE * (reference - way[0])


@inlined
def _slopes(state: Any, flux: float, along: float, across: float) -> tuple[float, float]:
    """Return by how much the torque rises with the load angle, and with the flux.

    Parameters
    ----------
    flux : float
        Magnitude of the stator flux linkage (V s).
    along, across : float
        Cosine and sine of the load angle, which is that of the flux from the magnet's axis.

    Returns
    -------
    angle_slope, flux_slope : float
        Partial derivatives (N m/rad, N m/(V s)) of ``T = k (x i_q - y i_d)`` with ``x = F cos d``, ``y = F sin d``,
        ``i_d = (x - psi) / L_d`` and ``i_q = y / L_q``, where k is three halves of the pole pairs.
    """
    constant = 1.5 * state.pole_pairs
    apart = 1.0 / state.quadrature_inductance - 1.0 / state.direct_inductance
    magnet = state.magnet_flux / state.direct_inductance
    angle_slope = flux * (magnet * along + flux * apart * (along * along - across * across))
    flux_slope = magnet * across + 2.0 * flux * apart * along * across
    return constant * angle_slope, constant * flux_slope


@inlined
def _short_of_pull_out(state: Any, flux: float, along: float, across: float, angle: float) -> float:
    """Return the part of a step of the load angle that leads no further than to the greatest torque of the flux (rad).

    Notes
    -----
    With ``s = L_q - L_d`` the torque of ``F (cos d, sin d)`` goes with ``(L_q psi - s F cos d) sin d``; it is greatest
    where ``2 s F cos(d)**2 - L_q psi cos d - s F = 0``, and falls beyond.
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
    """Return cosine and sine of the load angle, and by how much flux is to grow along and across itself (V s)."""
    x = state.direct_inductance * direct + state.magnet_flux
    y = state.quadrature_inductance * quadrature
    x_wanted = state.direct_inductance * direct_reference + state.magnet_flux
    y_wanted = state.quadrature_inductance * quadrature_reference
    flux = max(sqrt(x * x + y * y), _LEAST_FLUX * state.magnet_flux)
    along, across = x / flux, y / flux
    longer = sqrt(x_wanted * x_wanted + y_wanted * y_wanted) - flux
    torque = torque_per_quadrature(state, direct) * quadrature
    more = torque_per_quadrature(state, direct_reference) * quadrature_reference - torque
    angle_slope, flux_slope = _slopes(state, flux, along, across)
    least = _LEAST_SLOPE * 1.5 * state.pole_pairs * state.magnet_flux * flux / state.quadrature_inductance
    angle = (more - flux_slope * longer) / max(angle_slope, least)
    return along, across, longer, flux * _short_of_pull_out(state, flux, along, across, angle)


@inlined
def _leading_voltage(state: Any, electrical: float) -> tuple[float, float]:
    """Return the voltage of the rotor frame that takes the flux of the reference along its way (V)."""
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
    """Write the duty ratios that lead torque and flux to those of the reference's currents.

    Parameters
    ----------
    state : record of FOC_STATE
        Updated; its two integrals are of the rotor frame.
    direct, quadrature : float
        Measured currents of the rotor frame (A).
    direct_reference, quadrature_reference : float
        (A).

    Returns
    -------
    float
        Peak voltage of a phase that was asked for (V).

    Notes
    -----
    Along the stator flux the voltage changes its magnitude, across it the load angle and so the torque: regulators of
    these two, and the voltage by space-vector modulation, as in Buja and Kazmierkowski, "Direct torque control of PWM
    inverter-fed AC motors - a survey", IEEE Transactions on Industrial Electronics 51(4), 2004. Both are freed of each
    other by the slopes of the torque, after Awan, Hinkkanen, Bojoi and Pellegrino, "Stator-flux-oriented control of
    synchronous motors: a systematic design procedure", IEEE Transactions on Industry Applications 55(5), 2019. What is
    known beforehand is not left to them: the voltage that takes the flux of the reference along its way.
    """
    electrical = state.pole_pairs * sense.speed
    bandwidth = BANDWIDTH / state.control_period
    _next_on_way(state.direct_way, direct_reference)
    _next_on_way(state.quadrature_way, quadrature_reference)
    # The answer of this step is seen one period later, or two.
    seen = 1 + state.delay
    direct_due, quadrature_due = state.direct_way[seen], state.quadrature_way[seen]
    along, across, longer, turned = _flux_errors(state, direct, quadrature, direct_due, quadrature_due)
    # Of the rotor frame, as what the model does not know mostly is: a step of the torque turns the flux, not it.
    error, across_error = along * longer - across * turned, across * longer + along * turned
    leading, across_leading = _leading_voltage(state, electrical)
    leading += bandwidth * error + state.direct_integral
    across_leading += bandwidth * across_error + state.quadrature_integral
    # That which turns what is left of the flux is added as far as the limit bears it, as with the current regulators.
    added = electrical * state.quadrature_inductance * (quadrature_due - quadrature)
    across_added = -electrical * state.direct_inductance * (direct_due - direct)
    given, across_given = limited_voltage(leading, across_leading, added, across_added, voltage_limit(sense))
    wanted, across_wanted = leading + added, across_leading + across_added
    # What the limit has taken does not enter the integrals.
    error += (given - wanted) / bandwidth
    across_error += (across_given - across_wanted) / bandwidth
    state.direct_integral += state.direct_integral_step / state.direct_inductance * error
    state.quadrature_integral += state.quadrature_integral_step / state.quadrature_inductance * across_error
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.lead)
    give_voltage(
        state, sense, command, ahead, (given, across_given), (direct_reference, quadrature_reference)
    )
    return float(sqrt(wanted * wanted + across_wanted * across_wanted))
