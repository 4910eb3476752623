"""Start of a machine without a position sensor: a current vector aligns the rotor, and then turns it."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import regulate_currents, rotor_currents
from drivegate_models.controllers.duty.flux_observer import argument
from drivegate_models.controllers.duty.sensorless_state import ALIGNING
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.sine import cosine_sine

# Current of a start and the greatest one with damping, over the limit. Alignment lasts for so many periods of the
# rotor's swing, up to a time (s) and a share of the start time; the ramp for some at least.
_START_CURRENT: Final = 0.8
_MOST_CURRENT: Final = 0.95
_ALIGNED_PERIODS: Final = 4.0
_LONGEST_ALIGNED: Final = 0.5
_ALIGNED_SHARE: Final = 0.3
_RAMP_PERIODS: Final = 2.0
# Share of the pull-out torque that the load of a start, half of rated torque, and the acceleration use; and the least
# share for the acceleration.
_USED_TORQUE: Final = 0.8
_LEAST_USED: Final = 0.1
_START_LOAD: Final = 0.5
# Damping ratio of the swing, and rates by which the induced voltage and its mean follow, over the swing's.
_DAMPING: Final = 0.9
_FAST: Final = 10.0
_SLOW: Final = 0.3
_SALIENT: Final = 0.5
# Speed over the least one from which the induced voltage shows the rotor.
_SHOWN: Final = 0.2


@inlined
def reset_field(state: Any, nameplate: Any) -> None:
    """Write the constants of a start."""
    current = _START_CURRENT * nameplate.current_limit
    torque = 1.5 * nameplate.pole_pairs * nameplate.magnet_flux * current
    rate = sqrt(nameplate.pole_pairs * torque / nameplate.inertia)
    state.start_current = current
    state.swing_period = 2.0 * pi / rate
    longest = _LONGEST_ALIGNED
    if nameplate.start_time > 0.0:
        longest = min(longest, _ALIGNED_SHARE * nameplate.start_time)
    aligned = min(_ALIGNED_PERIODS * state.swing_period, longest)
    state.align_periods = int(aligned / nameplate.control_period) + 1
    load = _START_LOAD * nameplate.rated_power / nameplate.base_speed
    left = max(_USED_TORQUE * torque - load, _LEAST_USED * torque)
    slowest = state.handover_speed / (_RAMP_PERIODS * state.swing_period)
    state.acceleration = min(nameplate.pole_pairs * left / nameplate.inertia, slowest)
    state.damping = rate * nameplate.magnet_flux / (2.0 * _DAMPING * current)
    # The induced voltage is computed with the mean inductance, whose error must not make the damping swing by itself.
    saliency = 0.5 * abs(nameplate.quadrature_inductance - nameplate.direct_inductance)
    fastest = min(_FAST * rate, _SALIENT * state.damping / max(saliency, 1e-9))
    state.fast_share = min(fastest * nameplate.control_period, 0.5)
    state.slow_share = _SLOW * rate * nameplate.control_period
    place_field(state, 0.0, 0.0)


@inlined
def place_field(state: Any, angle: float, speed: float) -> None:
    """Set the angle (rad) and the speed (rad/s) of the current vector."""
    state.field = within_half_turn(angle)
    state.field_speed = speed
    for axis in range(2):
        state.induced[axis] = 0.0
        state.mean_induced[axis] = 0.0


@inlined
def follow_induced(state: Any, along: float, across: float, voltage: tuple[float, float]) -> None:
    """Follow the induced voltage along and across the current vector, without that of a rotor that follows.

    `along`, `across`: currents in the stationary frame (A). `voltage`: what acted on them in that frame (V).
    """
    machine = state.machine
    inductance = 0.5 * (machine.direct_inductance + machine.quadrature_inductance)
    rate, half = inductance / machine.control_period, 0.5 * machine.resistance
    before, across_before = state.along_before, state.across_before
    induced = voltage[0] - half * (along + before) - rate * (along - before)
    across_induced = voltage[1] - half * (across + across_before) - rate * (across - across_before)
    cosine, sine = cosine_sine(state.field)
    parts = cosine * induced + sine * across_induced, cosine * across_induced - sine * induced
    # A rotor that follows without a load induces this across the vector.
    followed = 0.0, state.field_speed * machine.magnet_flux
    for axis in range(2):
        state.induced[axis] += state.fast_share * (parts[axis] - followed[axis] - state.induced[axis])
        state.mean_induced[axis] += state.slow_share * (state.induced[axis] - state.mean_induced[axis])


@inlined
def turn_field(state: Any, sense: Any, command: Any, target: float) -> None:
    """Write the duty ratios of the current vector, and turn it at a speed that goes to a target (rad/s).

    A rotor that swings about a constant current is not damped. A current against the change of the induced voltage acts
    as a resistance across the windings, which damps it at any angle.
    """
    machine = state.machine
    step = state.acceleration * machine.control_period
    state.field_speed = min(max(target, state.field_speed - step), state.field_speed + step)
    state.field = within_half_turn(state.field + machine.control_period * state.field_speed)
    machine.seen = sense
    seen = machine.seen
    seen.angle = state.field / machine.pole_pairs
    seen.speed = state.field_speed / machine.pole_pairs
    direct, quadrature = rotor_currents(machine, seen)
    along = state.start_current - (state.induced[0] - state.mean_induced[0]) / state.damping
    across = -(state.induced[1] - state.mean_induced[1]) / state.damping
    most, size = _MOST_CURRENT * machine.current_limit, sqrt(along * along + across * across)
    share = most / size if size > most else 1.0
    regulate_currents(machine, seen, command, direct, quadrature, share * along, share * across)


@inlined
def rotor_of_field(state: Any) -> float:
    """Return the angle of the rotor that follows the current vector (rad), by the voltage that it induces.

    That is a quarter turn ahead of the magnet in the sense of rotation, and too small at low speed to show anything.
    """
    along, across = state.induced[0], state.induced[1] + state.field_speed * state.machine.magnet_flux
    if abs(state.field_speed) < _SHOWN * state.least_speed or (along == 0.0 and across == 0.0):
        return float(state.field)
    ahead = 0.5 * pi if state.field_speed > 0.0 else -0.5 * pi
    return float(state.field) + argument(along, across) - ahead


@inlined
def align(state: Any, sense: Any, command: Any) -> bool:
    """Hold the current along one direction and then along another; return True once the rotor is aligned.

    A rotor opposite to the first direction feels no torque, but then one a quarter turn off the second.
    """
    first = state.align_periods // 2
    if state.age == first:
        state.field = state.sense_of_start * 0.5 * pi
    turn_field(state, sense, command, 0.0)
    return bool(state.mode == ALIGNING and state.age >= first + state.align_periods)
