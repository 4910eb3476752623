"""Voltage that resistance, inductance and magnet do not explain: that of a wrong position, or of an open phase."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import magnitude
from drivegate_models.machine.sine import cosine_sine

# Share of the present unexplained voltage in its mean, and its maximum over the link: the applied voltage reversed.
# More is a wrong sample. What other than nominal data explain of the mean: shares of the magnet's EMF, of the
# voltages across inductance and resistance, and of the link; of what dead time and drops take in a leg, where the
# current over its limit is sure of its sign and where it is not, since three legs lose a vector; and at standstill
# the EMF of a speed over base speed that an encoder of few lines does not resolve. For how many control periods it is
# more.
_RATE: Final = 0.125
_REVERSED: Final = 4.0 / 3.0
_MAGNET: Final = 0.3
_INDUCTIVE: Final = 0.35
_RESISTIVE: Final = 1.0
_LINK: Final = 0.01
_LOST: Final = 0.5
_ALL_LOST: Final = 4.0 / 3.0
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
# Control periods without an edge of an encoder from which its speed is bounded: more than a lost sample takes.
_SILENT_PERIODS: Final = 4


@inlined
def reset_voltage(state: Any) -> None:
    """Forget what has been unexplained."""
    state.voltage_count = 0
    state.off_count = 0
    state.along_before = nan
    state.across_before = 0.0
    state.mean_speed = nan
    state.direct_unexplained = 0.0
    state.quadrature_unexplained = 0.0
    state.direct_changing = 0.0
    state.quadrature_changing = 0.0
    state.angle_missed = 0.0
    state.voltage_angle = nan
    state.edge_turn = inf
    state.silent_count = 0


@inlined
def _greatest_speed(state: Any, sense: Any) -> float:
    """Return the greatest speed of a shaft whose sensor shows no other angle than some periods before (rad/s).

    An encoder shows a mean over milliseconds, and so goes on turning after its last edge. Its angle does not: in that
    time the shaft turns by no more than between the last two angles.
    """
    before = state.voltage_angle
    state.voltage_angle = sense.angle
    if isnan(before):
        # The first step has no preceding step.
        return inf
    turned = abs(within_half_turn(float(sense.angle - before)))
    if turned > 0.0:
        state.edge_turn = turned
        state.silent_count = 0
    else:
        state.silent_count += 1
    if state.silent_count < _SILENT_PERIODS:
        return inf
    return float(state.edge_turn / (state.silent_count * state.machine.control_period))


@inlined
def _unexplained_voltage(
    state: Any, sense: Any, speed: float, direct: float, quadrature: float
) -> tuple[float, float]:
    """Return the d and q voltages of the last period that machine data do not explain (V), NaN before the second one.

    The speed (rad/s) and the d and q currents are given (A). Their change is taken in the stationary frame, where the
    steps of an encoder do not appear. The mean of the voltage that changes them is stored.
    """
    machine = state.machine
    electrical = float(machine.pole_pairs * speed)
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
    changing, across_changing = machine.direct_inductance * rate, machine.quadrature_inductance * across_rate
    if not isnan(changing):
        state.direct_changing += _RATE * (changing - state.direct_changing)
        state.quadrature_changing += _RATE * (across_changing - state.quadrature_changing)
    missed = cosine * applied + sine * across_applied - machine.resistance * direct
    missed -= changing - electrical * machine.quadrature_inductance * quadrature
    across_missed = cosine * across_applied - sine * applied - machine.resistance * quadrature
    across_missed -= across_changing
    across_missed -= electrical * (machine.direct_inductance * direct + machine.magnet_flux)
    return missed, across_missed


@inlined
def is_voltage_wrong(state: Any, sense: Any, direct: float, quadrature: float) -> bool:
    """Return True if more voltage has been unexplained for some periods than other data explain.

    The d and q currents are given (A). Half as much in two periods is enough with an angle off the observed shaft, or
    with an overdue Hall edge.
    """
    machine = state.machine
    greatest = _greatest_speed(state, sense) if sense.hall < 0 else inf
    shown = min(max(sense.speed, -greatest), greatest)
    missed, across_missed = _unexplained_voltage(state, sense, shown, direct, quadrature)
    before = sense.speed if isnan(state.mean_speed) else state.mean_speed
    state.mean_speed = before + _SPEED_RATE * (sense.speed - before)
    # Between Hall edges angle and speed are too uncertain, unless an edge is overdue.
    if isnan(missed) or (sense.hall >= 0 and machine.is_overdue == 0):
        state.voltage_count, state.off_count = 0, 0
        return False
    most, size = _REVERSED * sense.supply_voltage, magnitude(missed, across_missed)
    if size > most:
        missed, across_missed = missed * most / size, across_missed * most / size
    state.direct_unexplained += _RATE * (missed - state.direct_unexplained)
    state.quadrature_unexplained += _RATE * (across_missed - state.quadrature_unexplained)
    speed = abs(float(machine.pole_pairs * shown))
    changing = machine.pole_pairs * min(abs(sense.speed - state.mean_speed), greatest)
    amplitude = min(magnitude(direct, quadrature), machine.full_current)
    unresolved = machine.pole_pairs * max(_UNRESOLVED * state.base_speed - 0.5 * abs(state.mean_speed), 0.0)
    if abs(sense.speed) < abs(state.mean_speed):
        # An encoder that has turned shows at least the speed that the time since its last edge allows.
        unresolved = 0.0
    # A speed that is not resolved yet is not behind.
    allowed = (_MAGNET * speed + max(changing, unresolved)) * machine.magnet_flux
    inductive = speed * machine.quadrature_inductance * amplitude
    allowed += _INDUCTIVE * (inductive + magnitude(state.direct_changing, state.quadrature_changing))
    allowed += _RESISTIVE * machine.resistance * amplitude
    lost = machine.dead_ratio * sense.supply_voltage + 0.5 * (machine.switch_drop + machine.diode_drop)
    allowed += _LINK * sense.supply_voltage
    allowed += (_LOST if amplitude > _SURE * machine.full_current else _ALL_LOST) * lost
    unexplained = magnitude(state.direct_unexplained, state.quadrature_unexplained)
    state.voltage_count = state.voltage_count + 1 if unexplained > allowed else 0
    is_off = sense.hall >= 0 or abs(float(machine.pole_pairs * state.angle_missed)) > _OFF
    is_off = is_off and magnitude(missed, across_missed) > _CONFIRMING * allowed
    state.off_count = state.off_count + 1 if is_off else 0
    return bool(state.off_count >= _CONFIRMED_PERIODS or state.voltage_count >= _VOLTAGE_PERIODS)
