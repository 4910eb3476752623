"""What field-oriented control holds its sensors and its machine to, and the safe state that it goes to for good.

Four things that no drive in order does: phase currents whose sum is not zero, a shaft whose angle does not turn by its
speed or that stops faster than torque and inertia allow, one that stands under the greatest torque, and a phase
without a current while the field turns past it. Hall switches show a speed at their edges alone; where they stay as
they are although the magnet still induces a voltage, the position is lost.
"""

from __future__ import annotations

from math import floor, pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_OFF

CURRENT_FAULT: Final = 1
"""Code of currents whose sum is not zero: a sensor shows another one."""
SHAFT_FAULT: Final = 2
"""Code of an angle that does not turn by its speed, or of a shaft that stops too fast: its sensor, or it is locked."""
STALL_FAULT: Final = 3
"""Code of a shaft that stands under the greatest torque."""
PHASE_FAULT: Final = 4
"""Code of a phase without a current."""

# Sum of the currents over the limit; sensors with errors of a few thousandths each stay below it.
_CURRENT_SUM = 0.05
# Control periods for which a sum, or a speed, has to be implausible.
_SEEN = 5
# Angle in whose course a difference between angle and speed is forgotten, and how far it may get (rad electrical).
_FORGOTTEN = 1.2
_FARTHEST = 0.25
# Deceleration over that of the greatest torque and the inertia, and the speed over base speed below which it is not
# looked at: half of it for a load of the greatest torque, and once more for an inertia that is half the nominal one.
_STEEPEST = 4.0
_SLOW = 0.05
_STOPPED = 0.5
# Speed over base speed at which a shaft stands, and torque over the greatest.
_STANDING = 0.01
_FULL = 0.95
# For how long: in control periods, at most (s), and at least what a shaft under load takes to turn faster than that,
# over the time in which the greatest torque alone takes it to base speed.
_STALLED_PERIODS = 300
_STALLED_MOST = 0.04
_STALLED_LEAST = 0.06
# Voltage that the field induces over that of the speed at the last edge, from which on it turns; and the least flux
# along the magnet's axis that this goes by, over the magnet's own.
_INDUCED = 0.5
# Torque over the greatest that is left to turn a shaft past a sector of its Hall switches where the load is heavy.
_LEFT = 0.1
# Current of a phase over that of all, current of all over the limit from which on it is looked at, and angle that the
# field turns by meanwhile (rad electrical).
_MISSING = 0.03
_CARRYING = 0.15
_PASSED = pi / 4.0

_TURN = 2.0 * pi


@inlined
def reset_plausibility(state: Any, nameplate: Any) -> None:
    """Write the constants and forget every suspicion.

    Parameters
    ----------
    state : record of FOC_STATE
        Receives them; its greatest torque is set.
    """
    period = nameplate.control_period
    state.base_speed = nameplate.base_speed
    state.slowing_step = _STEEPEST * state.greatest_torque / nameplate.inertia * period
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
    state.hall_watched = -1
    state.speed_seen = 0.0
    state.sum_count = 0
    state.speed_count = 0
    state.stall_count = 0
    for phase in range(3):
        state.passed[phase] = 0.0


@inlined
def _turned(state: Any, sense: Any) -> float:
    """Return by how much the angle has turned since the step before (rad electrical)."""
    turned = float(state.pole_pairs * (sense.angle - state.angle_before))
    state.angle_before = sense.angle
    return turned - _TURN * floor(turned / _TURN + 0.5)


@inlined
def _is_sum_wrong(state: Any, sense: Any) -> bool:
    """Tell whether the currents' sum has not been zero for some periods."""
    currents = sense.phase_currents
    total = double_at(currents, 0) + double_at(currents, 1) + double_at(currents, 2)
    state.sum_count = state.sum_count + 1 if abs(total) > _CURRENT_SUM * state.current_limit else 0
    return bool(state.sum_count >= _SEEN)


@inlined
def _is_shaft_wrong(state: Any, sense: Any, turned: float, shows_speed: bool) -> bool:
    """Tell whether angle and speed disagree, or a speed that was shown has gone faster than the shaft can."""
    expected = state.pole_pairs * sense.speed * state.control_period
    drift = max(1.0 - abs(expected) / _FORGOTTEN, 0.0) * state.angle_drift + turned - expected
    state.angle_drift = drift
    # Hall switches give steps of 60 degrees before they give a speed.
    if sense.hall < 0 and abs(drift) > _FARTHEST:
        return True
    speed = abs(sense.speed)
    # Follows a rising speed at once, and a falling one as fast as the shaft can.
    state.speed_seen = max(speed if shows_speed else 0.0, state.speed_seen - state.slowing_step)
    stops = speed < _STOPPED * state.speed_seen and state.speed_seen > _SLOW * state.base_speed
    state.speed_count = state.speed_count + 1 if stops else 0
    return bool(state.speed_count >= _SEEN)


@inlined
def _is_position_lost(state: Any, sense: Any) -> bool:
    """Return True if no Hall edge comes any more although the magnet's field still turns past the winding."""
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
    """Tell whether a shaft that is to turn has stood under the greatest torque for long."""
    standing = _STANDING * state.base_speed
    pushed = abs(state.torque) >= _FULL * state.greatest_torque
    # Hall switches show a shaft that begins to turn, or that stands, by their edges alone.
    longest = state.stall_periods if sense.hall < 0 else state.hall_stall_periods
    stands = abs(sense.speed) < standing if sense.hall < 0 else not has_edge
    stands = stands and standing < abs(sense.reference)
    state.stall_count = state.stall_count + 1 if state.regulates_speed == 1 and stands and pushed else 0
    return bool(state.stall_count >= longest)


@inlined
def _passed_by(state: Any, sense: Any, turned: float) -> float:
    """Return by how much the field has turned past the phases, which a step at a Hall edge does not do."""
    if sense.hall < 0:
        return turned
    return min(abs(turned), abs(float(state.pole_pairs * sense.speed * state.control_period)))


@inlined
def _is_phase_missing(state: Any, sense: Any, turned: float) -> bool:
    """Tell whether the field has turned past a phase that has had no current."""
    currents = sense.phase_currents
    most = max(abs(double_at(currents, 0)), abs(double_at(currents, 1)), abs(double_at(currents, 2)))
    carrying = most > _CARRYING * state.current_limit
    missing = False
    for phase in range(3):
        without = carrying and abs(double_at(currents, phase)) < _MISSING * most
        state.passed[phase] = state.passed[phase] + abs(turned) if without else 0.0
        missing = missing or state.passed[phase] > _PASSED
    return missing


@inlined
def look_for_faults(state: Any, sense: Any) -> bool:
    """Return whether something is, or has been, what no drive in order does.

    Parameters
    ----------
    state : record of FOC_STATE
        Updated; keeps the code of the first fault.

    Returns
    -------
    bool
        Whether the safe state is to be held.
    """
    if state.fault != 0:
        return True
    if state.is_watching == 0:
        # There is no step before the first.
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
    elif _is_shaft_wrong(state, sense, turned, sense.hall < 0 or has_edge) or _is_position_lost(state, sense):
        state.fault = SHAFT_FAULT
    elif _is_stalled(state, sense, has_edge):
        state.fault = STALL_FAULT
    elif _is_phase_missing(state, sense, _passed_by(state, sense, turned)):
        state.fault = PHASE_FAULT
    return bool(state.fault != 0)


@inlined
def hold_safe_state(state: Any, command: Any) -> None:
    """Answer with all legs off and the code of the fault.

    Parameters
    ----------
    state : record of FOC_STATE
        With the code.
    """
    command.first_duty = 0.5
    command.second_duty = 0.5
    command.third_duty = 0.5
    command.first_leg = LEG_OFF
    command.second_leg = LEG_OFF
    command.third_leg = LEG_OFF
    command.next_period = 0.0
    command.fault = state.fault
