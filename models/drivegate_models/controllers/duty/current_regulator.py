"""Current regulators in the rotor frame: PI with decoupling, and duty ratios with a min-max zero sequence."""

from __future__ import annotations

from math import isnan, nan, sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine.rotor_frame import PER_ROOT_THREE, from_phases, of_phase
from drivegate_models.machine.sine import cosine_sine

BANDWIDTH: Final = 0.2
"""Bandwidth of the current regulators relative to the sampling rate, stable with a delay of 1.5 periods."""

# Rate of the integrals relative to that of the currents. What they collect during a step decays later, as overshoot.
_INTEGRAL = 0.05
# Share of the voltage that would move the currents without decoupling from which decoupling has priority.
_LEAST_MOVING = 0.5
# Current, as a share of the limit, from which compensation of the bridge is complete. It is small, because a wider ramp
# leaves ripple at a low voltage, and the reference current used for compensation has no noise.
_DEAD_SHARE = 0.0005
# Shortest pulse or gap over a carrier period, which a counter of ten bits does not round away.
_SHORTEST = 0.001


@inlined
def reset_regulator(state: Any, nameplate: Any) -> None:
    """Write the constants of the current regulators and reset everything else."""
    bandwidth = BANDWIDTH / nameplate.control_period
    state.pole_pairs = nameplate.pole_pairs
    state.resistance = nameplate.resistance
    state.direct_inductance = nameplate.direct_inductance
    state.quadrature_inductance = nameplate.quadrature_inductance
    state.magnet_flux = nameplate.magnet_flux
    state.current_limit = nameplate.current_limit
    state.lead = (nameplate.update_delay + 0.5) * nameplate.control_period
    state.delay = 1 if nameplate.update_delay > 0 else 0
    # Dead time occurs once per carrier period, which consists of two control periods with double update.
    halves = 2.0 if nameplate.updates == 2 else 1.0
    carrier_period = halves * nameplate.control_period / nameplate.control_every
    state.dead_ratio = nameplate.dead_time / carrier_period
    state.dead_current = _DEAD_SHARE * nameplate.current_limit
    state.switch_drop = nameplate.switch_drop
    state.diode_drop = nameplate.diode_drop
    state.half_carrier = 0.5 * carrier_period
    state.edge_centre = 0.5 if nameplate.updates == 2 else 0.0
    state.remaining_error = max(1.0 - BANDWIDTH * (nameplate.update_delay + 0.5), 0.0)
    state.direct_gain = bandwidth * nameplate.direct_inductance
    state.quadrature_gain = bandwidth * nameplate.quadrature_inductance
    state.direct_integral_step = BANDWIDTH * max(nameplate.resistance, _INTEGRAL * state.direct_gain)
    state.quadrature_integral_step = BANDWIDTH * max(nameplate.resistance, _INTEGRAL * state.quadrature_gain)
    state.direct_integral = 0.0
    state.quadrature_integral = 0.0
    state.direct_moved = 0.0
    state.quadrature_moved = 0.0
    for command in range(2):
        # Until the first command acts, the legs are off and their voltages unknown.
        state.along_voltage[command] = nan
        state.across_voltage[command] = nan


@inlined
def rotor_currents(state: Any, sense: Any) -> tuple[float, float]:
    """Return the measured d-axis and q-axis currents (A)."""
    currents = sense.phase_currents
    along, across = from_phases(double_at(currents, 0), double_at(currents, 1), double_at(currents, 2))
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    return cosine * along + sine * across, cosine * across - sine * along


@inlined
def largest_current(sense: Any) -> float:
    """Return the largest magnitude of the phase currents (A)."""
    currents = sense.phase_currents
    return float(max(abs(double_at(currents, 0)), abs(double_at(currents, 1)), abs(double_at(currents, 2))))


@inlined
def voltage_limit(state: Any, sense: Any) -> float:
    """Return the linear modulation limit: the maximum peak phase voltage without distortion (V).

    While the machine drives, current flows through two switches from one rail to the other.
    """
    return float(max(sense.supply_voltage - 2.0 * state.switch_drop, 0.0) * PER_ROOT_THREE)


@inlined
def limited_voltage(
    along: float, across: float, added_along: float, added_across: float, limit: float
) -> tuple[float, float]:
    """Return a voltage with as much of the added one as the limit allows, or the nearest one within the limit (V)."""
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
    """Write the duty ratios for a voltage in the stationary frame (V), centred in the link voltage `supply` (V)."""
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
def _compensated_ratio(state: Any, ratio: float, current: float, rise: float, per_volt: float) -> float:
    """Return a duty ratio with compensation of dead time and drops for a current (A).

    `rise` is the current above that in the middle when the leg turns on (A), and below it when the leg turns off. A
    current that has different signs at the two edges loses no time at either. `per_volt` is a duty ratio over its
    voltage (1/V). A current into the machine flows through the upper switch and the lower diode, and the opposite one
    through the other two; either way, both drops oppose it.
    """
    on = min(max((current + rise) / state.dead_current, -1.0), 1.0)
    off = min(max((current - rise) / state.dead_current, -1.0), 1.0)
    sign = 0.5 * (on + off)
    upper, lower = state.switch_drop, state.diode_drop
    if sign < 0.0:
        upper, lower = lower, upper
    drop = per_volt * (ratio * upper + (1.0 - ratio) * lower)
    return float(ratio + sign * (state.dead_ratio + drop))


@inlined
def _flux_at_edge(ratio: float, first: float, second: float, third: float) -> tuple[float, float]:
    """Return the ripple of the flux, along and across the first phase's axis, when the leg of a duty ratio turns on.

    The period is centred on the pulses of the three duty ratios. The unit is the supply times half of a carrier period.
    """
    before = 1.0 - ratio
    return from_phases(
        max(first - ratio, 0.0) - before * first,
        max(second - ratio, 0.0) - before * second,
        max(third - ratio, 0.0) - before * third,
    )


@inlined
def _ripple_of(state: Any, turned: tuple[float, float], leg: int, flux: tuple[float, float]) -> float:
    """Return the current of a phase (A) that belongs to a flux in the stationary frame (V s)."""
    cosine, sine = turned
    direct = (cosine * flux[0] + sine * flux[1]) / state.direct_inductance
    quadrature = (cosine * flux[1] - sine * flux[0]) / state.quadrature_inductance
    return of_phase(leg, cosine * direct - sine * quadrature, sine * direct + cosine * quadrature)


@inlined
def _rise_at_edge(
    state: Any,
    turned: tuple[float, float],
    moved: tuple[float, float],
    leg: int,
    ratio: float,
    ratios: tuple[float, float, float],
    unit: float,
) -> float:
    """Return the current of a phase when its leg turns on, above that in the middle of a control period (A).

    It is the ripple, and what the current moves until then. `moved` is what the current in the stationary frame turns
    back in half a carrier period (A), and `unit` the supply times that time (V s).
    """
    along, across = _flux_at_edge(ratio, ratios[0], ratios[1], ratios[2])
    ripple = _ripple_of(state, turned, leg, (unit * along, unit * across))
    return float(ripple + (ratio - state.edge_centre) * of_phase(leg, moved[0], moved[1]))


@inlined
def _shift_to_rail(least: float, lowest: float, highest: float) -> float:
    """Return the common shift of three duty ratios to the lower rail, where compensation takes one beyond a rail.

    `least` is of the duty ratios without compensation, `lowest` and `highest` with it. A common shift changes no
    voltage of the machine, whereas one duty ratio cut at a rail does. At the upper rail, the gap between two periods
    would still lose its dead time.
    """
    return 0.0 if lowest >= _SHORTEST and highest <= 1.0 - _SHORTEST else -least


@inlined
def _shifted(ratio: float, compensated: float, shift: float) -> float:
    """Return a compensated duty ratio with a common shift; a leg at a rail does not switch, and loses no time."""
    if shift < 0.0 and ratio + shift <= 0.0:
        return 0.0
    return float(min(max(compensated + shift, 0.0), 1.0))


@inlined
def compensate_bridge(
    state: Any,
    command: Any,
    turned: tuple[float, float],
    electrical: float,
    direct: float,
    quadrature: float,
    supply: float,
) -> None:
    """Compensate the command's duty ratios for dead time, and for the drops of switches and diodes, if there are any.

    `turned` is the cosine and sine of the rotor's electrical angle while the duty ratios act, and `electrical` its
    speed (rad/s). `direct` and `quadrature` are the reference currents at that time (A), and `supply` is the link
    voltage (V).
    """
    drops = state.switch_drop + state.diode_drop
    if state.dead_ratio <= 0.0 and drops <= 0.0:
        return
    # A link that shows hardly a voltage is a lost sample.
    per_volt = 1.0 / supply if supply > 2.0 * drops else 0.0
    cosine, sine = turned
    along, across = cosine * direct - sine * quadrature, sine * direct + cosine * quadrature
    first, second, third = command.first_duty, command.second_duty, command.third_duty
    ratios, unit, turning = (
        (first, second, third),
        supply * state.half_carrier,
        electrical * state.half_carrier,
    )
    moved = (turning * across, -turning * along)
    rise = _rise_at_edge(state, turned, moved, 0, first, ratios, unit)
    second_rise = _rise_at_edge(state, turned, moved, 1, second, ratios, unit)
    third_rise = _rise_at_edge(state, turned, moved, 2, third, ratios, unit)
    one = _compensated_ratio(state, first, along, rise, per_volt)
    two = _compensated_ratio(state, second, of_phase(1, along, across), second_rise, per_volt)
    three = _compensated_ratio(state, third, of_phase(2, along, across), third_rise, per_volt)
    shift = _shift_to_rail(min(first, second, third), min(one, two, three), max(one, two, three))
    command.first_duty = _shifted(first, one, shift)
    command.second_duty = _shifted(second, two, shift)
    command.third_duty = _shifted(third, three, shift)


@inlined
def write_voltage(
    state: Any,
    sense: Any,
    command: Any,
    turned: tuple[float, float],
    halfway: tuple[float, float],
    voltage: tuple[float, float],
    current: tuple[float, float],
) -> None:
    """Write the duty ratios for d-axis and q-axis voltages (V), with the bridge compensated for d and q currents (A).

    `turned` is the cosine and sine of the rotor's electrical angle in whose frame the voltages are, and `halfway` that
    in the middle of the control period in which the duty ratios act.
    """
    cosine, sine = turned
    along, across = voltage
    state.quadrature_voltage = across
    state.along_voltage[1], state.across_voltage[1] = state.along_voltage[0], state.across_voltage[0]
    state.along_voltage[0] = cosine * along - sine * across
    state.across_voltage[0] = sine * along + cosine * across
    supply = max(sense.supply_voltage, 1e-9)
    write_ratios(command, state.along_voltage[0], state.across_voltage[0], supply)
    electrical = state.pole_pairs * sense.speed
    compensate_bridge(state, command, halfway, electrical, current[0], current[1], supply)


@inlined
def limited_request(
    steady: tuple[float, float], moving: tuple[float, float], coupling: tuple[float, float], limit: float
) -> tuple[float, float]:
    """Return the sum of the d and q voltages that maintain, move and decouple the currents, within the limit (V).

    If the currents move at least half as fast in addition to all others as without decoupling, they are decoupled: in
    a long step at a high speed, what is not decoupled becomes a current far beyond its reference. Otherwise decoupling
    is added as far as the limit allows.
    """
    moved_along, moved_across = steady[0] + moving[0], steady[1] + moving[1]
    direct, quadrature = limited_voltage(moved_along, moved_across, coupling[0], coupling[1], limit)
    along, across = steady[0] + coupling[0], steady[1] + coupling[1]
    if along * along + across * across < limit * limit:
        decoupled, other = limited_voltage(along, across, moving[0], moving[1], limit)
        moved = (decoupled - along) * moving[0] + (other - across) * moving[1]
        if moved >= _LEAST_MOVING * ((direct - along) * moving[0] + (quadrature - across) * moving[1]):
            return decoupled, other
    return direct, quadrature


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
    """Write the duty ratios that move the measured currents (A) to their references (A).

    Return the requested peak phase voltage (V), before the limit.

    With the error ``x`` of the flux linkage, ``x' = v - v_r - j w x - R (i - i_r)``, where ``v_r`` is the voltage
    that maintains the references. The rotation ``j w x`` does no work on ``|x|**2``, so its decoupling is useful
    but optional, and part of ``K x`` reduces the error as well. Limiting ``v_r - K x`` to the nearest voltage within
    the limit reduces the error wherever ``v_r`` is within the limit: ``(P(y) - v_r) . (y - P(y)) >= 0`` for a
    projection ``P`` onto a convex set. A limit that prefers one axis does not: during braking it maintains currents
    far beyond their references. Forces that do no work: Ortega, Loria, Nicklasson and Sira-Ramirez, "Passivity-based
    Control of Euler-Lagrange Systems", Springer, 1998.
    """
    limit = voltage_limit(state, sense)
    electrical = state.pole_pairs * sense.speed
    direct_error = direct_reference - direct
    quadrature_error = quadrature_reference - quadrature
    moving, across_moving = state.direct_gain * direct_error, state.quadrature_gain * quadrature_error
    # What is left of the errors in the middle of the period in which the command acts, after half of its own effect and
    # that of the command that waits: more decoupling than that couples again.
    direct_flux = state.direct_inductance * direct_error
    quadrature_flux = state.quadrature_inductance * quadrature_error
    if isnan(state.direct_moved):
        direct_flux *= state.remaining_error
        quadrature_flux *= state.remaining_error
    else:
        half = 0.5 * state.control_period
        direct_flux -= state.direct_moved + half * moving
        quadrature_flux -= state.quadrature_moved + half * across_moving
    # The voltages that maintain the references, that move the currents to them, and that decouple them.
    steady = state.direct_integral - electrical * state.quadrature_inductance * quadrature_reference
    across_steady = state.quadrature_integral + electrical * (
        state.direct_inductance * direct_reference + state.magnet_flux
    )
    coupling, across_coupling = electrical * quadrature_flux, -electrical * direct_flux
    direct_voltage = steady + moving + coupling
    quadrature_voltage = across_steady + across_moving + across_coupling
    direct_limited, quadrature_limited = limited_request(
        (steady, across_steady), (moving, across_moving), (coupling, across_coupling), limit
    )
    waiting = state.delay * state.control_period
    used = sqrt(direct_voltage * direct_voltage + quadrature_voltage * quadrature_voltage)
    is_whole = used <= limit
    # What a voltage cut by the limit moves is not known; then a decay of the errors is assumed that lasts.
    state.direct_moved = waiting * moving if is_whole else nan
    state.quadrature_moved = waiting * across_moving if is_whole else nan
    # Anti-windup: the voltage cut by the limit does not enter the integrals.
    state.direct_integral += state.direct_integral_step * (
        direct_error + (direct_limited - direct_voltage) / state.direct_gain
    )
    state.quadrature_integral += state.quadrature_integral_step * (
        quadrature_error + (quadrature_limited - quadrature_voltage) / state.quadrature_gain
    )
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.lead)
    voltage, current = (direct_limited, quadrature_limited), (direct_reference, quadrature_reference)
    write_voltage(state, sense, command, ahead, ahead, voltage, current)
    return float(used)
