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
_RAMP_PERIODS: Final = 1.5
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
# Least current of the vector over that of a start, what is left of an eighth of a turn between it and the rotor from
# which it is not reduced further (1), and halvings of the search for the angle of a torque.
_LEAST_CURRENT: Final = 0.2
_EASED: Final = 0.3
_HALVINGS: Final = 30
# Rate at which the current is reduced, over that of the swing's periods, and greatest current of the damping over it.
_EASING: Final = 2.0
_MOST_DAMPING: Final = 0.5
# Greatest difference of the resistance from the nameplate's over it (1).
_OTHER_RESISTANCE: Final = 0.5
# Share of an inductance that a machine has at least.
_SURE_SHARE: Final = 0.8


@inlined
def _damped_inductance(machine: Any) -> float:
    """Return the inductance that the induced voltage is computed with (H).

    It is less than a nameplate that is 20 % off states of the axis across the vector.
    """
    mean = 0.5 * (machine.direct_inductance + machine.quadrature_inductance)
    return float(min(mean, _SURE_SHARE * machine.quadrature_inductance))


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
    # Where it is too great, it must not make the damping swing by itself.
    excess = _damped_inductance(nameplate) - nameplate.direct_inductance
    fastest = min(_FAST * rate, _SALIENT * state.damping / max(excess, 1e-9))
    state.fast_share = min(fastest * nameplate.control_period, 0.5)
    state.slow_share = _SLOW * rate * nameplate.control_period
    place_field(state, 0.0, 0.0)


@inlined
def place_field(state: Any, angle: float, speed: float) -> None:
    """Set the angle (rad) and the speed (rad/s) of the current vector."""
    state.field = within_half_turn(angle)
    state.field_speed = speed
    state.current = state.start_current
    for axis in range(2):
        state.induced[axis] = 0.0
        state.mean_induced[axis] = 0.0


@inlined
def place_loaded_field(state: Any, angle: float, speed: float, torque: float) -> None:
    """Place the current vector so far ahead of a rotor (rad, rad/s) that it has a torque (N m).

    With the angle ``a`` between both, ``T = 1.5 p I sin(a) (psi + (L_d - L_q) I cos(a))``, which grows up to the angle
    of pull-out.
    """
    machine = state.machine
    current, flux = state.start_current, machine.magnet_flux
    turned = (machine.quadrature_inductance - machine.direct_inductance) * current
    share = abs(torque) / (1.5 * machine.pole_pairs * current)
    # Cosines of no torque and of pull-out, where the torque's slope is zero.
    low, high = 1.0, -2.0 * turned / (flux + sqrt(flux * flux + 8.0 * turned * turned))
    for _ in range(_HALVINGS):
        cosine = 0.5 * (low + high)
        if sqrt(1.0 - cosine * cosine) * (flux - turned * cosine) < share:
            low = cosine
        else:
            high = cosine
    cosine = 0.5 * (low + high)
    sine = sqrt(1.0 - cosine * cosine)
    if torque < 0.0:
        sine = -sine
    place_field(state, angle + argument(cosine, sine), speed)
    induced = speed * flux * sine, speed * flux * (cosine - 1.0)
    for axis in range(2):
        state.induced[axis] = induced[axis]
        state.mean_induced[axis] = induced[axis]


@inlined
def follow_induced(state: Any, along: float, across: float, voltage: tuple[float, float]) -> None:
    """Follow the induced voltage along and across the current vector, without that of a rotor that follows.

    `along`, `across`: currents in the stationary frame (A). `voltage`: what acted on them in that frame (V).
    """
    machine = state.machine
    inductance = _damped_inductance(machine)
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
def learn_resistance(state: Any) -> None:
    """Take over the resistance of an aligned rotor at rest, which alone needs a voltage then."""
    machine = state.machine
    other = _OTHER_RESISTANCE * machine.resistance
    machine.resistance += min(max(state.mean_induced[0] / state.current, -other), other)
    for axis in range(2):
        state.induced[axis] = 0.0
        state.mean_induced[axis] = 0.0


@inlined
def turn_field(state: Any, sense: Any, command: Any, target: float, least: float) -> None:
    """Write the duty ratios of the current vector, and turn it at a speed that goes to a target (rad/s).

    A rotor that swings about a constant current is not damped. A current against the change of the induced voltage acts
    as a resistance across the windings, which damps it at any angle. It leaves a least current (A), since a load needs
    that.
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
    along = -(state.induced[0] - state.mean_induced[0]) / state.damping
    across = -(state.induced[1] - state.mean_induced[1]) / state.damping
    size = sqrt(along * along + across * across)
    bound = _MOST_DAMPING * state.current
    part = bound / size if size > bound else 1.0
    along, across = state.current + part * along, part * across
    most, size = _MOST_CURRENT * machine.current_limit, sqrt(along * along + across * across)
    share = 1.0
    if size > most:
        share = most / size
    elif size < least:
        share = least / size
    regulate_currents(machine, seen, command, direct, quadrature, share * along, share * across)


@inlined
def _induced_by_rotor(state: Any) -> tuple[float, float]:
    """Return the voltage along and across the vector that is a quarter turn ahead of the magnet (V).

    It is what the voltage across L_q leaves.
    """
    machine = state.machine
    left = machine.quadrature_inductance - _damped_inductance(machine)
    flux = machine.magnet_flux - left * state.current
    return float(state.induced[0]), float(state.induced[1] + state.field_speed * flux)


@inlined
def rotor_of_field(state: Any) -> float:
    """Return the angle of the rotor that follows the current vector (rad), by the voltage that it induces.

    That is a quarter turn ahead of the magnet in the sense of rotation, and too small at low speed to show anything.
    """
    along, across = _induced_by_rotor(state)
    if abs(state.field_speed) < _SHOWN * state.least_speed or (along == 0.0 and across == 0.0):
        return float(state.field)
    ahead = 0.5 * pi if state.field_speed > 0.0 else -0.5 * pi
    return float(state.field) + argument(along, across) - ahead


@inlined
def ease_current(state: Any) -> bool:
    """Reduce the vector's current until the rotor lags by an eighth of a turn; return True once it nearly does.

    An observer errs by what resistance and inductances of another machine do to a current along the magnet.
    """
    along, across = _induced_by_rotor(state)
    size = sqrt(along * along + across * across)
    ahead = across if state.field_speed > 0.0 else -across
    left = (ahead - abs(along)) / max(size, 1e-9)
    eased = state.current * (1.0 - _EASING * left * state.machine.control_period / state.swing_period)
    least = _LEAST_CURRENT * state.start_current
    state.current = min(max(eased, least), state.start_current)
    return bool(left < _EASED or state.current == least)


@inlined
def align(state: Any, sense: Any, command: Any) -> bool:
    """Turn the current by half a turn in the sense of the start, and hold it; return True once the rotor is aligned.

    A rotor opposite to the first direction feels no torque, but then one of the vector that has turned. Since the
    vector comes to meet it, the rotor turns back by less than half a turn.
    """
    first = state.align_periods // 2
    if state.age < first:
        state.field += state.sense_of_start * pi / first
    turn_field(state, sense, command, 0.0, 0.0)
    return bool(state.mode == ALIGNING and state.age >= first + state.align_periods)
