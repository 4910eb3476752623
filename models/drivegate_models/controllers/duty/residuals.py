"""Failure detector of `load-observer`, by what the model of machine and shaft does not explain.

It shares no check with `plausibility`. If the position is wrong, resistance, inductance and magnet do not explain the
applied voltage, and the angle is off the observed shaft. Other residuals are the sum of the currents, currents that do
not follow their references, an angle that jumps, and an angle that does not follow its speed. A shaft that stands under
more torque than any load is locked.
"""

from __future__ import annotations

from math import isnan, nan, pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.machine.sine import cosine_sine

CURRENT_FAULT: Final = 1
"""Code of currents with a sum other than zero."""
POSITION_FAULT: Final = 2
"""Code of an angle that jumps, or does not follow its speed."""
STALL_FAULT: Final = 3
"""Code of a shaft that stands under more torque than any load."""
PHASE_FAULT: Final = 4
"""Code of a phase whose current does not follow its reference."""
VOLTAGE_FAULT: Final = 5
"""Code of a voltage that the model does not explain: a lost position, or an open phase."""

# Sum of the currents that errors of their sensors explain: relative to the limit, and to the sum of their magnitudes;
# and for how many control periods it is more, because single samples get lost.
_OFFSETS: Final = 0.015
_GAINS: Final = 0.02
_SUM_PERIODS: Final = 5
# Share of the present unexplained voltage in its mean. What other than nominal data explain of the mean: shares of the
# magnet's EMF, of the voltage across inductance and resistance, of the link, and of that lost by dead time and drops,
# where the current over its limit is sure of its sign; and at standstill the EMF of a speed over base speed that an
# encoder of few lines does not resolve. For how many control periods it is more.
_RATE: Final = 0.125
_MAGNET: Final = 0.3
_INDUCTIVE: Final = 0.35
_RESISTIVE: Final = 1.0
_LINK: Final = 0.01
_LOST: Final = 0.5
_SURE: Final = 0.1
_UNRESOLVED: Final = 0.05
_VOLTAGE_PERIODS: Final = 6
# Share of the measured speed in its mean. An encoder shows a mean over milliseconds: while a light rotor changes
# its speed, the EMF of the difference is unexplained as well.
_SPEED_RATE: Final = 1.0 / 64.0
# Difference between the shown and the observed angle (rad electrical), and the present unexplained voltage over what is
# allowed of the mean, that both together show a wrong position; and for how many control periods.
_OFF: Final = 0.15
_CONFIRMING: Final = 0.5
_CONFIRMED_PERIODS: Final = 2
# Amplitude of the reference currents relative to the limit from which phases are watched; reference of a phase relative
# to that amplitude, and current along it relative to it, below which a phase does not follow; and for how many periods.
# At a Hall edge the shown angle jumps, and the currents need some periods to follow.
_CARRYING: Final = 0.05
_EXPECTED: Final = 0.5
_FOLLOWING: Final = 0.25
_PHASE_PERIODS: Final = 8
_HALL_PHASE_PERIODS: Final = 32
# Share of the present error of the flux in its mean, and present error over the mean below which the error shrinks.
_ERROR_RATE: Final = 0.125
_SHRINKING: Final = 0.995
# Difference between the turns in two periods that no shaft makes (rad electrical).
_JUMP: Final = 0.5
# Angle over which a difference between angle and speed decays, its maximum (rad electrical), and speed relative to
# base speed below which it is not checked.
_FORGOTTEN: Final = 1.5
_BEHIND: Final = 0.75
_SLOW: Final = 0.1
# Speed that counts as standstill relative to base speed; torque that no load withstands, relative to the rated and to
# the maximum torque; and its time: in control periods, its maximum (s), and relative to the time to base speed.
_STANDING: Final = 0.01
_HEAVIEST: Final = 1.2
_FULL: Final = 0.95
_STALL_PERIODS: Final = 250
_STALL_MOST: Final = 0.04
_STALL_RUN_UP: Final = 0.05
# The same with Hall switches: relative to that time, and torque left under a heavy load to turn a shaft by a sector.
_HALL_STALL: Final = 2.0
_LEFT: Final = 0.1


@inlined
def reset_detector(state: Any, nameplate: Any) -> None:
    """Write the constants and reset all residuals; the maximum torque must be set."""
    most, period = state.machine.greatest_torque, nameplate.control_period
    state.fault = 0
    state.sum_count = 0
    state.still_count = 0
    state.voltage_count = 0
    state.off_count = 0
    state.along_before = nan
    state.across_before = 0.0
    state.mean_speed = nan
    state.direct_unexplained = 0.0
    state.quadrature_unexplained = 0.0
    for phase in range(3):
        state.missing[phase] = 0
    state.direct_aim = 0.0
    state.quadrature_aim = 0.0
    state.mean_error = 0.0
    state.shrinks = 0
    state.angle_before = 0.0
    state.turned = nan
    state.angle_missed = 0.0
    state.behind = 0.0
    state.hall_before = -1
    state.base_speed = nameplate.base_speed
    state.stalling = min(_FULL * most, _HEAVIEST * nameplate.rated_power / nameplate.base_speed)
    run_up = nameplate.inertia * nameplate.base_speed / most
    longest = max(min(_STALL_PERIODS * period, _STALL_MOST), _STALL_RUN_UP * run_up)
    state.still_longest = int(longest / period)
    sector = pi / (3.0 * nameplate.pole_pairs)
    passed = sqrt(2.0 * sector * nameplate.inertia / (_LEFT * most))
    state.hall_still_longest = int(max(_HALL_STALL * longest, passed) / period)


@inlined
def _length(along: float, across: float) -> float:
    return sqrt(along * along + across * across)


@inlined
def _flux_error(machine: Any, direct: float, quadrature: float) -> float:
    """Return the magnitude of the flux linkage of d and q currents (V s)."""
    return _length(machine.direct_inductance * direct, machine.quadrature_inductance * quadrature)


@inlined
def _is_sum_wrong(state: Any, sense: Any) -> bool:
    """Return True if the sum of the currents has been more than the sensors' errors for some periods."""
    total, magnitudes = 0.0, 0.0
    for phase in range(3):
        current = double_at(sense.phase_currents, phase)
        total += current
        magnitudes += abs(current)
    allowed = _OFFSETS * state.machine.current_limit + _GAINS * magnitudes
    state.sum_count = state.sum_count + 1 if abs(total) > allowed else 0
    return bool(state.sum_count >= _SUM_PERIODS)


@inlined
def _unexplained_voltage(state: Any, sense: Any, direct: float, quadrature: float) -> tuple[float, float]:
    """Return the d and q voltages of the last period that machine data do not explain (V), NaN before the second one.

    The d and q currents are given (A). Their change is taken in the stationary frame, where the steps of an encoder do
    not appear.
    """
    machine = state.machine
    electrical = float(machine.pole_pairs * sense.speed)
    period = machine.control_period
    angle = float(machine.pole_pairs * sense.angle)
    cosine, sine = cosine_sine(angle)
    along, across = cosine * direct - sine * quadrature, sine * direct + cosine * quadrature
    changed, across_changed = along - state.along_before, across - state.across_before
    state.along_before, state.across_before = along, across
    along, across = along - 0.5 * changed, across - 0.5 * across_changed
    applied, across_applied = machine.along_voltage[machine.delay], machine.across_voltage[machine.delay]
    # In the middle of the period.
    cosine, sine = cosine_sine(angle - 0.5 * electrical * period)
    direct, quadrature = cosine * along + sine * across, cosine * across - sine * along
    rate = (cosine * changed + sine * across_changed) / period + electrical * quadrature
    across_rate = (cosine * across_changed - sine * changed) / period - electrical * direct
    missed = cosine * applied + sine * across_applied - machine.resistance * direct
    missed -= machine.direct_inductance * rate - electrical * machine.quadrature_inductance * quadrature
    across_missed = cosine * across_applied - sine * applied - machine.resistance * quadrature
    across_missed -= machine.quadrature_inductance * across_rate
    across_missed -= electrical * (machine.direct_inductance * direct + machine.magnet_flux)
    return missed, across_missed


@inlined
def _is_voltage_wrong(state: Any, sense: Any, direct: float, quadrature: float) -> bool:
    """Return True if more voltage has been unexplained for some periods than other data explain.

    The d and q currents are given (A). Half as much in two periods is enough with an angle off the observed shaft, or
    with an overdue Hall edge.
    """
    machine = state.machine
    missed, across_missed = _unexplained_voltage(state, sense, direct, quadrature)
    before = sense.speed if isnan(state.mean_speed) else state.mean_speed
    state.mean_speed = before + _SPEED_RATE * (sense.speed - before)
    # Between Hall edges angle and speed are too uncertain, unless an edge is overdue.
    if isnan(missed) or (sense.hall >= 0 and machine.is_overdue == 0):
        state.voltage_count, state.off_count = 0, 0
        return False
    state.direct_unexplained += _RATE * (missed - state.direct_unexplained)
    state.quadrature_unexplained += _RATE * (across_missed - state.quadrature_unexplained)
    speed = abs(float(machine.pole_pairs * sense.speed))
    changing = abs(float(machine.pole_pairs * (sense.speed - state.mean_speed)))
    amplitude = min(_length(direct, quadrature), machine.current_limit)
    unresolved = machine.pole_pairs * max(_UNRESOLVED * state.base_speed - 0.5 * abs(state.mean_speed), 0.0)
    allowed = (_MAGNET * speed + changing + unresolved) * machine.magnet_flux
    allowed += _INDUCTIVE * speed * machine.quadrature_inductance * amplitude
    allowed += _RESISTIVE * machine.resistance * amplitude
    lost = machine.dead_ratio * sense.supply_voltage + 0.5 * (machine.switch_drop + machine.diode_drop)
    allowed += (
        _LINK * sense.supply_voltage + (_LOST if amplitude > _SURE * machine.current_limit else 1.0) * lost
    )
    unexplained = _length(state.direct_unexplained, state.quadrature_unexplained)
    state.voltage_count = state.voltage_count + 1 if unexplained > allowed else 0
    is_off = sense.hall >= 0 or abs(float(machine.pole_pairs * state.angle_missed)) > _OFF
    is_off = is_off and _length(missed, across_missed) > _CONFIRMING * allowed
    state.off_count = state.off_count + 1 if is_off else 0
    return bool(state.off_count >= _CONFIRMED_PERIODS or state.voltage_count >= _VOLTAGE_PERIODS)


@inlined
def _is_phase_missing(state: Any, sense: Any) -> bool:
    """Return True if a phase has not followed its reference for some periods.

    The diodes of an open leg carry current at little inductance, but hardly any along a reference of some size.
    """
    machine = state.machine
    longest = _PHASE_PERIODS if sense.hall < 0 else _HALL_PHASE_PERIODS
    cosine, sine = cosine_sine(machine.pole_pairs * sense.angle)
    along = cosine * state.direct_aim - sine * state.quadrature_aim
    across = sine * state.direct_aim + cosine * state.quadrature_aim
    amplitude = _length(along, across)
    if amplitude < _CARRYING * machine.current_limit:
        return False
    missing = False
    for phase in range(3):
        aim = of_phase(phase, along, across)
        if abs(aim) < _EXPECTED * amplitude:
            continue
        current = double_at(sense.phase_currents, phase)
        if (current if aim > 0.0 else -current) > _FOLLOWING * abs(aim):
            state.missing[phase] = 0
        else:
            # In a long step the current vector may stand while it shrinks.
            state.missing[phase] = (
                max(state.missing[phase] - 1, 0) if state.shrinks == 1 else state.missing[phase] + 1
            )
        missing = missing or state.missing[phase] >= longest
    return missing


@inlined
def _is_position_wrong(state: Any, sense: Any) -> bool:
    """Return True if the angle jumps, or has not followed its speed."""
    machine = state.machine
    if sense.hall >= 0:
        return False
    expected = float(machine.pole_pairs * sense.speed * machine.control_period)
    before = state.turned
    if isnan(before):
        # The first step has no preceding step.
        state.angle_before, state.turned = sense.angle, expected
        return False
    turned = within_half_turn(float(machine.pole_pairs * (sense.angle - state.angle_before)))
    state.angle_before, state.turned = sense.angle, turned
    left = max(1.0 - abs(expected) / _FORGOTTEN, 0.0)
    state.behind = left * state.behind + turned - expected
    turns = abs(sense.speed) > _SLOW * state.base_speed
    return bool(abs(turned - before) > _JUMP or (turns and abs(state.behind) > _BEHIND))


@inlined
def _is_stalled(state: Any, sense: Any) -> bool:
    """Return True if a shaft with a speed reference has been at standstill under more torque than any load for long."""
    machine = state.machine
    standing = _STANDING * state.base_speed
    by_hall = sense.hall >= 0
    stands = sense.hall == state.hall_before if by_hall else abs(sense.speed) < standing
    state.hall_before = sense.hall
    # An angle that is off by half a sector leaves less torque than the regulator requests.
    least = _FULL * machine.greatest_torque if by_hall else state.stalling
    stalls = machine.regulates_speed == 1 and stands and abs(state.torque) >= least
    stalls = stalls and abs(sense.reference) > standing
    state.still_count = state.still_count + 1 if stalls else 0
    return bool(state.still_count >= (state.hall_still_longest if by_hall else state.still_longest))


@inlined
def detect_failure(state: Any, sense: Any, direct: float, quadrature: float) -> bool:
    """Return True if a failure has been detected, now or before, and store the code of the first one."""
    if state.fault != 0:
        return True
    if _is_sum_wrong(state, sense):
        state.fault = CURRENT_FAULT
    elif _is_position_wrong(state, sense):
        state.fault = POSITION_FAULT
    elif _is_voltage_wrong(state, sense, direct, quadrature):
        state.fault = VOLTAGE_FAULT
    elif _is_phase_missing(state, sense):
        state.fault = PHASE_FAULT
    elif _is_stalled(state, sense):
        state.fault = STALL_FAULT
    return bool(state.fault != 0)


@inlined
def watch_currents(
    state: Any, direct: float, quadrature: float, direct_aim: float, quadrature_aim: float
) -> None:
    """Store the reference currents (A), and whether the measured ones (A) approach them."""
    machine = state.machine
    before = _flux_error(machine, state.direct_aim - direct, state.quadrature_aim - quadrature)
    state.shrinks = 1 if before < _SHRINKING * state.mean_error else 0
    after = _flux_error(machine, direct_aim - direct, quadrature_aim - quadrature)
    # A reference that moves changes the mean error as much as the present one.
    mean = state.mean_error + _ERROR_RATE * (before - state.mean_error)
    state.mean_error = max(mean + after - before, 0.0)
    state.direct_aim, state.quadrature_aim = direct_aim, quadrature_aim
