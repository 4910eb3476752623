"""Failure detector of `load-observer`, by what the model of machine and shaft does not explain.

It shares no check with `plausibility`. If the position is wrong, resistance, inductance and magnet do not explain the
applied voltage, and the angle is off the observed shaft. Other residuals are the sum of the currents, currents that do
not follow their references, an angle that jumps, and an angle that does not follow its speed. A shaft that stands under
more torque than any load is locked.
"""

from __future__ import annotations

from math import inf, isnan, nan, pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import largest_current
from drivegate_models.controllers.duty.missing_phase import FREE
from drivegate_models.controllers.duty.unexplained_voltage import is_voltage_wrong, reset_voltage
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import magnitude, of_phase
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
# and for how many control periods it is more: a fast regulator has much torque after five with a wrong sensor.
_OFFSETS: Final = 0.015
_GAINS: Final = 0.02
_SUM_PERIODS: Final = 3
# Amplitude of the reference currents relative to the limit from which phases are watched; reference of a phase relative
# to that amplitude, and current along it relative to it, below which a phase does not follow; and for how many periods,
# or for which rotation of a fast field (rad electrical).
# At a Hall edge the shown angle jumps, and the currents need some periods to follow.
_CARRYING: Final = 0.05
_EXPECTED: Final = 0.5
_FOLLOWING: Final = 0.25
_PHASE_PERIODS: Final = 12
_HALL_PHASE_PERIODS: Final = 32
_PHASE_TURN: Final = 1.5
# Near the voltage limit references may be out of reach, so that only a phase without current is missing: for which
# rotation of the field a sound one has less than that share of the largest current (rad).
_PASSING: Final = 0.7
# Share of the present error of the flux in its mean, and present error over the mean below which the error shrinks;
# that from this share of the voltage limit on, where it shrinks slowly.
_ERROR_RATE: Final = 0.125
_SHRINKING: Final = 0.995
_LIMITED: Final = 0.99
_SHRINKING_LIMITED: Final = 0.9999
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
    reset_voltage(state)
    state.fault = 0
    state.sum_count = 0
    state.still_count = 0
    for phase in range(3):
        state.missing[phase] = 0
    state.direct_aim = 0.0
    state.quadrature_aim = 0.0
    state.mean_error = inf
    state.shrinks = 0
    state.angle_before = 0.0
    state.turned = nan
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
def _flux_error(machine: Any, direct: float, quadrature: float) -> float:
    """Return the magnitude of the flux linkage of d and q currents (V s)."""
    return magnitude(machine.direct_inductance * direct, machine.quadrature_inductance * quadrature)


@inlined
def _is_sum_wrong(state: Any, sense: Any) -> bool:
    """Return True if the sum of the currents has been more than the sensors' errors for some periods."""
    total, magnitudes = 0.0, 0.0
    for phase in range(3):
        current = double_at(sense.phase_currents, phase)
        total += current
        magnitudes += abs(current)
    allowed = _OFFSETS * state.machine.full_current + _GAINS * magnitudes
    state.sum_count = state.sum_count + 1 if abs(total) > allowed else 0
    return bool(state.sum_count >= _SUM_PERIODS)


@inlined
def _is_phase_missing(state: Any, sense: Any) -> bool:
    """Return True if a phase has not followed its reference for some periods.

    The diodes of an open leg carry current at little inductance, but hardly any along a reference of some size.
    """
    machine = state.machine
    turned = abs(float(machine.pole_pairs * sense.speed * machine.control_period))
    longest = min(_PHASE_PERIODS, _PHASE_TURN / max(turned, 1e-9)) if sense.hall < 0 else _HALL_PHASE_PERIODS
    cosine, sine = cosine_sine(machine.pole_pairs * sense.angle)
    along = cosine * state.direct_aim - sine * state.quadrature_aim
    across = sine * state.direct_aim + cosine * state.quadrature_aim
    amplitude = magnitude(along, across)
    if amplitude < _CARRYING * machine.full_current:
        return False
    used = magnitude(machine.along_voltage[0], machine.across_voltage[0])
    is_limited = used > FREE * sense.supply_voltage
    if is_limited:
        longest = max(longest, min(_PASSING / max(turned, 1e-9), _HALL_PHASE_PERIODS))
    missing = False
    for phase in range(3):
        aim = of_phase(phase, along, across)
        if abs(aim) < _EXPECTED * amplitude:
            continue
        current = double_at(sense.phase_currents, phase)
        along_aim, least = (current if aim > 0.0 else -current), abs(aim)
        if is_limited:
            along_aim, least = abs(current), min(least, largest_current(sense))
        if along_aim > _FOLLOWING * least:
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
    least = _FULL * machine.full_torque if by_hall else state.stalling
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
    elif is_voltage_wrong(state, sense, direct, quadrature):
        state.fault = VOLTAGE_FAULT
    elif _is_phase_missing(state, sense):
        state.fault = PHASE_FAULT
    elif _is_stalled(state, sense):
        state.fault = STALL_FAULT
    return bool(state.fault != 0)


@inlined
def watch_currents(
    state: Any, limit: float, direct: float, quadrature: float, direct_aim: float, quadrature_aim: float
) -> None:
    """Store the reference currents (A), and whether the measured ones (A) approach them under a voltage limit (V)."""
    machine = state.machine
    is_limited = magnitude(machine.along_voltage[0], machine.across_voltage[0]) > _LIMITED * limit
    before = _flux_error(machine, state.direct_aim - direct, state.quadrature_aim - quadrature)
    if state.mean_error == inf:
        # Current may flow before the first reference, through the diodes.
        state.mean_error = before
    shrinking = _SHRINKING_LIMITED if is_limited else _SHRINKING
    state.shrinks = 1 if before < shrinking * state.mean_error else 0
    after = _flux_error(machine, direct_aim - direct, quadrature_aim - quadrature)
    # A reference that moves changes the mean error as much as the present one.
    mean = state.mean_error + _ERROR_RATE * (before - state.mean_error)
    state.mean_error = max(mean + after - before, 0.0)
    state.direct_aim, state.quadrature_aim = direct_aim, quadrature_aim
