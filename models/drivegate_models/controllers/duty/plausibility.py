"""Plausibility of the sensors and the machine, and the safe state that a fault latches.

Four faults are physically implausible in a healthy drive: phase currents with a sum other than zero; a shaft whose
angle disagrees with its speed and with the flux, or that stops faster than torque and inertia allow; a stall under more
torque than any load; and a phase with far less current than its reference while the field turns past it. Hall switches
measure a speed only at their edges. If their states remain constant although the magnet still induces a voltage, the
position is lost.
"""

from __future__ import annotations

from math import isnan, pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.controllers.duty.current_regulator import largest_current
from drivegate_models.controllers.duty.missing_phase import is_phase_missing, passed_by, reset_missing_phase
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import magnitude
from drivegate_models.machine.sine import cosine_sine

CURRENT_FAULT: Final = 1
"""Code of currents with a sum other than zero: a current sensor is faulty."""
SHAFT_FAULT: Final = 2
"""Code of an angle that disagrees with its speed, or of a shaft that stops too fast: faulty sensor, or locked shaft."""
STALL_FAULT: Final = 3
"""Code of a shaft at standstill under maximum torque."""
PHASE_FAULT: Final = 4
"""Code of a phase without current."""

# Sum of the currents relative to the limit; sensors with errors of a few thousandths remain below it. Number of control
# periods for which it is more: a fast regulator has much torque after five with a wrong sensor.
_CURRENT_SUM = 0.05
_SUM_SEEN = 3
# Number of control periods for which a speed must be implausible.
_SEEN = 5
# Angle over which a difference between angle and speed decays, and its maximum (rad electrical).
_FORGOTTEN = 1.2
_FARTHEST = 0.25
# Angle over which a difference between flux and voltage decays (rad electrical). The decay is at least that at this
# speed relative to base speed, because the voltage across the resistance is uncertain and does not fall with the speed.
_FLUX_FORGOTTEN = 0.6
_FLUX_SLOW = 0.2
# Unexplained flux by other than nominal data: shares of that of the currents, and of the link voltage; twice the
# nominal resistance is possible as well.
_INDUCTIVE_SHARE = 0.2
_LINK_SHARE = 0.015
# Maximum deceleration relative to that of maximum torque and inertia, and speed relative to base speed below which
# it is not checked. A factor of two is for a load of maximum torque, and the other one for 0.3 of the nominal inertia.
_STEEPEST = 2.0 / 0.3
_SLOW = 0.05
_STOPPED = 0.5
# Speed relative to base speed that counts as standstill. Torque that no load withstands: relative to maximum torque,
# and to rated torque, which is the heaviest load apart from friction.
_STANDING = 0.01
_FULL = 0.95
_BEYOND_LOAD = 1.2
# Time of a stall: in control periods, its maximum (s), and its minimum, the time of a loaded shaft to exceed that
# speed, relative to the time in which maximum torque alone accelerates it to base speed.
_STALLED_PERIODS = 300
_STALLED_MOST = 0.04
_STALLED_LEAST = 0.06
# Induced voltage that shows rotation, relative to that of the speed at the last edge; and minimum d-axis flux for this
# comparison, relative to the magnet's flux.
_INDUCED = 0.5
# Torque relative to the maximum that remains under a heavy load to turn the shaft past a sector of its Hall switches.
_LEFT = 0.1


@inlined
def reset_plausibility(state: Any, nameplate: Any) -> None:
    """Write the constants and reset all checks; the maximum torque must be set."""
    period = nameplate.control_period
    state.base_speed = nameplate.base_speed
    state.slowing_step = _STEEPEST * state.greatest_torque / nameplate.inertia * period
    heaviest = nameplate.rated_power / nameplate.base_speed
    state.stalling_torque = min(_FULL * state.greatest_torque, _BEYOND_LOAD * heaviest)
    run_up = nameplate.inertia * nameplate.base_speed / state.greatest_torque
    stalled = max(min(_STALLED_PERIODS * period, _STALLED_MOST), _STALLED_LEAST * run_up)
    state.stall_periods = int(stalled / period)
    sector = pi / (3.0 * nameplate.pole_pairs)
    passed = sqrt(2.0 * sector * nameplate.inertia / (_LEFT * state.greatest_torque))
    state.hall_stall_periods = int(max(2.0 * stalled, passed) / period)
    state.fault = 0
    state.is_watching = 0
    state.angle_before = 0.0
    state.angle_drift = 0.0
    state.farthest_drift = _FARTHEST
    state.flux_decay = _FLUX_SLOW * nameplate.pole_pairs * nameplate.base_speed * period
    state.along_drift = 0.0
    state.across_drift = 0.0
    state.hall_watched = -1
    state.speed_seen = 0.0
    state.flux_count = 0
    state.sum_count = 0
    state.speed_count = 0
    state.stall_count = 0
    reset_missing_phase(state, nameplate)


@inlined
def _turned(state: Any, sense: Any) -> float:
    """Return the rotation since the preceding step (rad electrical)."""
    turned = float(state.pole_pairs * (sense.angle - state.angle_before))
    state.angle_before = sense.angle
    return float(within_half_turn(turned))


@inlined
def _is_sum_wrong(state: Any, sense: Any) -> bool:
    """Return True if the sum of the currents has been other than zero for some periods."""
    currents = sense.phase_currents
    total = double_at(currents, 0) + double_at(currents, 1) + double_at(currents, 2)
    state.sum_count = state.sum_count + 1 if abs(total) > _CURRENT_SUM * state.full_current else 0
    return bool(state.sum_count >= _SUM_SEEN)


@inlined
def watch_flux(state: Any, sense: Any, direct: float, quadrature: float) -> None:
    """Sum the changes of the flux that the voltages do not explain; the measured d and q currents are given (A).

    In the stationary frame the flux linkage is the integral of ``v - R i``. Currents and angle show it as well. An
    angle that is not the magnet's makes a difference, a shaft that changes its speed does not.
    """
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    direct_flux = state.direct_inductance * direct + state.magnet_flux
    quadrature_flux = state.quadrature_inductance * quadrature
    along_flux = cosine * direct_flux - sine * quadrature_flux
    across_flux = sine * direct_flux + cosine * quadrature_flux
    # The voltage drop at the mean current of the period.
    drop = 0.5 * state.resistance
    along_drop = drop * (cosine * direct - sine * quadrature)
    across_drop = drop * (sine * direct + cosine * quadrature)
    along = state.along_voltage[state.delay]
    if not isnan(along):
        period = state.control_period
        along -= along_drop + state.along_drop
        across = state.across_voltage[state.delay] - across_drop - state.across_drop
        decay = max(abs(float(state.pole_pairs * sense.speed * period)), state.flux_decay)
        left = max(1.0 - decay / _FLUX_FORGOTTEN, 0.0)
        state.along_drift = left * state.along_drift + along_flux - state.along_flux - period * along
        state.across_drift = left * state.across_drift + across_flux - state.across_flux - period * across
    state.along_flux, state.across_flux = along_flux, across_flux
    state.along_drop, state.across_drop = along_drop, across_drop


@inlined
def _is_flux_wrong(state: Any, sense: Any) -> bool:
    """Return True if the flux alone has shown for some periods that the angle is wrong.

    The speed of an encoder soon falls to zero with a lost position. That of a slow shaft then never disagrees with the
    angle by the maximum drift.
    """
    most = largest_current(sense)
    decay = max(abs(float(state.pole_pairs * sense.speed * state.control_period)), state.flux_decay)
    rate = decay / (_FLUX_FORGOTTEN * state.control_period)
    voltage = state.resistance * most + (_LINK_SHARE + state.dead_ratio) * sense.supply_voltage
    allowed = state.farthest_drift * state.magnet_flux + _INDUCTIVE_SHARE * state.quadrature_inductance * most
    is_wrong = magnitude(state.along_drift, state.across_drift) > allowed + voltage / rate
    state.flux_count = state.flux_count + 1 if sense.hall < 0 and is_wrong else 0
    return bool(state.flux_count >= _SEEN)


@inlined
def _is_shaft_wrong(state: Any, sense: Any, turned: float, shows_speed: bool) -> bool:
    """Return True if angle and speed disagree, or a measured speed has fallen faster than the shaft can stop.

    The speed of an encoder is a mean over the recent past, behind which the angle of a light rotor is far ahead. An
    angle that is wrong disagrees with the flux as well.
    """
    expected = state.pole_pairs * sense.speed * state.control_period
    drift = max(1.0 - abs(expected) / _FORGOTTEN, 0.0) * state.angle_drift + turned - expected
    state.angle_drift = drift
    # Hall switches have steps of 60 degrees before they measure a speed.
    if sense.hall < 0 and abs(drift) > state.farthest_drift:
        unexplained = magnitude(state.along_drift, state.across_drift)
        if unexplained > _FARTHEST * state.magnet_flux:
            return True
    speed = abs(sense.speed)
    # Follow a speed as fast as the shaft can start and stop, or that of Hall switches, which rises in steps, at once.
    # A shaft that turns round just beyond an edge of its encoder passes that twice within moments, which looks fast.
    # Once a speed has fallen faster, wait: at low speed the shaft could stop within the periods for which that must
    # last.
    waits = sense.hall < 0 and state.speed_count > 0
    slowed = state.speed_seen if waits else state.speed_seen - state.slowing_step
    # While the shaft is braked, an encoder without a new edge still shows the speed of a while ago.
    is_old = turned == 0.0 and state.torque * sense.speed < 0.0
    shown = speed if shows_speed and not is_old else 0.0
    if sense.hall < 0:
        shown = min(shown, state.speed_seen + state.slowing_step)
    state.speed_seen = max(shown, slowed)
    stops = speed < _STOPPED * state.speed_seen and state.speed_seen > _SLOW * state.base_speed
    state.speed_count = state.speed_count + 1 if stops else 0
    return bool(state.speed_count >= _SEEN)


@inlined
def _is_position_lost(state: Any, sense: Any) -> bool:
    """Return True if no Hall edge appears although the magnet's field still turns past the winding."""
    if sense.hall < 0 or state.is_overdue == 0:
        return False
    before = state.edge_rate if state.regulates_speed == 1 else state.pole_pairs * state.hall_speed
    rise = (state.quadrature_seen - state.quadrature_before) / state.control_period
    dropped = state.resistance * state.quadrature_seen + state.quadrature_inductance * rise
    flux = state.magnet_flux + state.direct_inductance * state.direct_seen
    expected = max(flux, _INDUCED * state.magnet_flux) * abs(before)
    return bool(abs(state.quadrature_voltage - dropped) > _INDUCED * expected)


@inlined
def _is_stalled(state: Any, sense: Any, has_edge: bool) -> bool:
    """Return True if a shaft with a speed reference has been at standstill under more torque than any load for long."""
    standing = _STANDING * state.base_speed
    # An angle that is off by half a sector leaves less of a torque than the regulator requests.
    least = state.stalling_torque if sense.hall < 0 else _FULL * state.full_torque
    pushed = abs(state.torque) >= least
    # Hall switches show the start or the standstill of a shaft only by their edges.
    longest = state.stall_periods if sense.hall < 0 else state.hall_stall_periods
    stands = abs(sense.speed) < standing if sense.hall < 0 else not has_edge
    stands = stands and standing < abs(sense.reference)
    state.stall_count = state.stall_count + 1 if state.regulates_speed == 1 and stands and pushed else 0
    return bool(state.stall_count >= longest)


@inlined
def detect_fault(state: Any, sense: Any) -> bool:
    """Return True if a fault has been detected, now or before, and store the code of the first one."""
    if state.fault != 0:
        return True
    if state.is_watching == 0:
        # The first step has no preceding step.
        state.is_watching = 1
        state.angle_before = sense.angle
        state.hall_watched = sense.hall
        state.speed_seen = abs(sense.speed)
        return False
    turned = _turned(state, sense)
    has_edge = sense.hall != state.hall_watched
    state.hall_watched = sense.hall
    if _is_sum_wrong(state, sense):
        state.fault = CURRENT_FAULT
    elif (
        _is_shaft_wrong(state, sense, turned, sense.hall < 0 or has_edge)
        or _is_flux_wrong(state, sense)
        or _is_position_lost(state, sense)
    ):
        state.fault = SHAFT_FAULT
    elif _is_stalled(state, sense, has_edge):
        state.fault = STALL_FAULT
    elif is_phase_missing(state, sense, passed_by(state, sense, turned)):
        state.fault = PHASE_FAULT
    return bool(state.fault != 0)


@inlined
def hold_safe_state(state: Any, command: Any) -> None:
    """Command all legs off, with the code of the fault."""
    command.first_duty = 0.5
    command.second_duty = 0.5
    command.third_duty = 0.5
    command.first_leg = LEG_OFF
    command.second_leg = LEG_OFF
    command.third_leg = LEG_OFF
    command.next_period = 0.0
    command.fault = state.fault
