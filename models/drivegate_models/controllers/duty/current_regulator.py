"""Currents of the rotor frame, regulated: PI with decoupling, and duty ratios with a min-max zero sequence."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine.rotor_frame import PER_ROOT_THREE, from_phases, of_phase
from drivegate_models.machine.sine import cosine_sine

BANDWIDTH: Final = 0.2
"""Bandwidth of the currents over the sampling rate, which a delay of one and a half periods bears."""

_INTEGRAL = 0.1
# Current over the limit from which on the whole of a dead time is lost, or won: hardly more than none, since a wider
# ramp leaves ripple where the voltage is small, and the current that is wanted has no noise to be kept out.
_DEAD_SHARE = 0.0005


@inlined
def reset_regulator(state: Any, nameplate: Any) -> None:
    """Write the constants of the current regulators and forget everything else.

    Parameters
    ----------
    state : record of FOC_STATE
        Receives them.
    """
    bandwidth = BANDWIDTH / nameplate.control_period
    state.pole_pairs = nameplate.pole_pairs
    state.resistance = nameplate.resistance
    state.direct_inductance = nameplate.direct_inductance
    state.quadrature_inductance = nameplate.quadrature_inductance
    state.magnet_flux = nameplate.magnet_flux
    state.current_limit = nameplate.current_limit
    state.lead = (nameplate.update_delay + 0.5) * nameplate.control_period
    # Once in a period of the carrier, which two control periods with an update each may make up.
    halves = 2.0 if nameplate.updates == 2 else 1.0
    state.dead_ratio = nameplate.dead_time / (halves * nameplate.control_period)
    state.dead_current = _DEAD_SHARE * nameplate.current_limit
    state.direct_gain = bandwidth * nameplate.direct_inductance
    state.quadrature_gain = bandwidth * nameplate.quadrature_inductance
    state.direct_integral_step = BANDWIDTH * max(nameplate.resistance, _INTEGRAL * state.direct_gain)
    state.quadrature_integral_step = BANDWIDTH * max(nameplate.resistance, _INTEGRAL * state.quadrature_gain)
    state.direct_integral = 0.0
    state.quadrature_integral = 0.0


@inlined
def rotor_currents(state: Any, sense: Any) -> tuple[float, float]:
    """Return the measured currents along and across the magnet's axis (A)."""
    currents = sense.phase_currents
    along, across = from_phases(double_at(currents, 0), double_at(currents, 1), double_at(currents, 2))
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    return cosine * along + sine * across, cosine * across - sine * along


@inlined
def voltage_limit(sense: Any) -> float:
    """Return the greatest peak voltage of a phase without distortion (V)."""
    return float(max(sense.supply_voltage, 0.0) * PER_ROOT_THREE)


@inlined
def limited_voltage(
    along: float, across: float, added_along: float, added_across: float, limit: float
) -> tuple[float, float]:
    """Return a voltage with as much of what may be added to it as the limit bears; the nearest one beyond the limit."""
    square = limit * limit
    outside = along * along + across * across - square
    if outside >= 0.0:
        share = limit / sqrt(outside + square)
        return share * along, share * across
    whole = added_along * added_along + added_across * added_across
    both = along * added_along + across * added_across
    if outside + 2.0 * both + whole <= 0.0:
        return along + added_along, across + added_across
    share = -outside / (both + sqrt(both * both - whole * outside))
    return along + share * added_along, across + share * added_across


@inlined
def write_ratios(command: Any, along: float, across: float, supply: float) -> None:
    """Write the answer that gives a voltage in the frame that stands still, about the middle of the link (V)."""
    first, second, third = along, of_phase(1, along, across), of_phase(2, along, across)
    middle = 0.5 * (max(first, second, third) + min(first, second, third))
    share = 1.0 / supply
    command.first_duty = min(max(0.5 + share * (first - middle), 0.0), 1.0)
    command.second_duty = min(max(0.5 + share * (second - middle), 0.0), 1.0)
    command.third_duty = min(max(0.5 + share * (third - middle), 0.0), 1.0)
    command.first_leg = LEG_PWM
    command.second_leg = LEG_PWM
    command.third_leg = LEG_PWM
    command.next_period = 0.0
    command.fault = 0


@inlined
def _regained(state: Any, ratio: float, current: float) -> float:
    """Return a duty ratio with what dead time takes from it, or gives to it, made up for."""
    share = min(max(current / state.dead_current, -1.0), 1.0)
    return float(min(max(ratio + share * state.dead_ratio, 0.0), 1.0))


@inlined
def regain_dead_time(
    state: Any, command: Any, turned: tuple[float, float], direct: float, quadrature: float
) -> None:
    """Add to the duty ratios what dead time takes from them, where there is any.

    Parameters
    ----------
    command : record of DUTY_COMMAND
        Its duty ratios are updated.
    turned : tuple of float
        Cosine and sine of the rotor's electrical angle while the duty ratios act.
    direct, quadrature : float
        Currents of the rotor frame that are to flow then (A).
    """
    if state.dead_ratio <= 0.0:
        return
    cosine, sine = turned
    along, across = cosine * direct - sine * quadrature, sine * direct + cosine * quadrature
    command.first_duty = _regained(state, command.first_duty, along)
    command.second_duty = _regained(state, command.second_duty, of_phase(1, along, across))
    command.third_duty = _regained(state, command.third_duty, of_phase(2, along, across))


@inlined
def give_voltage(
    state: Any,
    sense: Any,
    command: Any,
    turned: tuple[float, float],
    given: tuple[float, float],
    wanted: tuple[float, float],
) -> None:
    """Write the answer that gives a voltage of the rotor frame.

    Parameters
    ----------
    turned : tuple of float
        Cosine and sine of the rotor's electrical angle while they act.
    given : tuple of float
        Voltage along and across the magnet's axis (V).
    wanted : tuple of float
        Currents along and across it that are to flow then (A), by which dead time is made up for.
    """
    cosine, sine = turned
    along, across = given
    write_ratios(
        command,
        cosine * along - sine * across,
        sine * along + cosine * across,
        max(sense.supply_voltage, 1e-9),
    )
    regain_dead_time(state, command, turned, wanted[0], wanted[1])


@inlined
def regulate_currents(
    state: Any,
    sense: Any,
    command: Any,
    direct: float,
    quadrature: float,
    direct_reference: float,
    quadrature_reference: float,
) -> float:
    """Write the duty ratios that lead the currents to their references.

    Parameters
    ----------
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
    With the error ``x`` of the flux linkage, ``x' = v - v_r - j w x - R (i - i_r)``, where ``v_r`` is the voltage that
    holds the references. The rotation ``j w x`` does no work on ``|x|**2``, so decoupling it is worth having and may be
    left out, and ``v_r - K x`` brought to the nearest voltage within the limit takes the error down wherever ``v_r`` is
    within it: ``(P(y) - v_r) . (y - P(y)) >= 0`` of a projection ``P`` onto a convex set. A limit that prefers one axis
    does not: braking, it holds currents far beyond their references. Forces that do no work: Ortega, Loria, Nicklasson
    and Sira-Ramirez, "Passivity-based Control of Euler-Lagrange Systems", Springer, 1998.
    """
    limit = voltage_limit(sense)
    electrical = state.pole_pairs * sense.speed
    direct_error = direct_reference - direct
    quadrature_error = quadrature_reference - quadrature
    direct_flux = state.direct_inductance * direct_error
    quadrature_flux = state.quadrature_inductance * quadrature_error
    # The voltage that holds the references and leads to them; decoupling is added as far as the limit bears it.
    along = (
        state.direct_gain * direct_error
        + state.direct_integral
        - electrical * state.quadrature_inductance * quadrature_reference
    )
    across = (
        state.quadrature_gain * quadrature_error
        + state.quadrature_integral
        + electrical * (state.direct_inductance * direct_reference + state.magnet_flux)
    )
    direct_voltage = along + electrical * quadrature_flux
    quadrature_voltage = across - electrical * direct_flux
    direct_given, quadrature_given = limited_voltage(
        along, across, electrical * quadrature_flux, -electrical * direct_flux, limit
    )
    # What the limit has taken does not enter the integrals.
    state.direct_integral += state.direct_integral_step * (
        direct_error + (direct_given - direct_voltage) / state.direct_gain
    )
    state.quadrature_integral += state.quadrature_integral_step * (
        quadrature_error + (quadrature_given - quadrature_voltage) / state.quadrature_gain
    )
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.lead)
    given, wanted = (direct_given, quadrature_given), (direct_reference, quadrature_reference)
    give_voltage(state, sense, command, ahead, given, wanted)
    return float(sqrt(direct_voltage * direct_voltage + quadrature_voltage * quadrature_voltage))
