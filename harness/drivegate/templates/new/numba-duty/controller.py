"""Field-oriented control.

A speed regulator, the least current for a torque, field weakening, current regulators with decoupling and anti-windup,
and min-max modulation. Every constant follows from the nameplate; all quantities are in SI units.
"""

from math import cos, sin, sqrt

import numba
import numpy as np

from drivegate import TORQUE_REFERENCE, NumbaController, phase_current

ROOT_THREE = 1.7320508075688772
# Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that.
CURRENT_SHARE, SPEED_SHARE, INTEGRAL_SHARE = 0.2, 0.02, 0.1
# Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a
# lower one leaves more, for a machine of less inductance than on the nameplate.
VOLTAGE_SHARE, BRAKING_SHARE = 0.985, 0.185

# All that the controller remembers. Nothing else lasts from one step to the next.
FIELDS = (
    "regulates_torque pole_pairs resistance direct_inductance quadrature_inductance saliency flux limit deepest "
    "greatest lead direct_gain quadrature_gain direct_step quadrature_step speed_gain speed_step weakening_step "
    "speed_integral direct_integral quadrature_integral weakening"
)
STATE = np.dtype([(name, np.float64) for name in FIELDS.split()])


def reset(state, nameplate):
    """Prepare for a run: called before every one, and must forget everything."""
    period = nameplate.control_period
    bandwidth = CURRENT_SHARE / period
    state.regulates_torque = nameplate.reference_kind == TORQUE_REFERENCE
    state.pole_pairs = nameplate.pole_pairs
    state.resistance = nameplate.resistance
    state.direct_inductance = nameplate.direct_inductance
    state.quadrature_inductance = nameplate.quadrature_inductance
    state.saliency = state.quadrature_inductance - state.direct_inductance
    state.flux = nameplate.magnet_flux
    state.limit = nameplate.current_limit
    # Beyond the magnet's whole flux the voltage rises again.
    state.deepest = -min(0.999 * state.limit, state.flux / state.direct_inductance)
    # The torque at the current limit, with the direct current that makes it the greatest.
    turned = 2.0 * state.saliency * state.limit
    direct = -turned * state.limit / (state.flux + sqrt(state.flux * state.flux + 2.0 * turned * turned))
    state.greatest = per_ampere(state, direct) * sqrt(state.limit * state.limit - direct * direct)
    # From the sample to the middle of the period in which the answer acts (s).
    state.lead = (nameplate.update_delay + 0.5) * period
    state.direct_gain = bandwidth * state.direct_inductance
    state.quadrature_gain = bandwidth * state.quadrature_inductance
    state.direct_step = CURRENT_SHARE * max(state.resistance, INTEGRAL_SHARE * state.direct_gain)
    state.quadrature_step = CURRENT_SHARE * max(state.resistance, INTEGRAL_SHARE * state.quadrature_gain)
    state.speed_gain = nameplate.inertia * SPEED_SHARE * bandwidth
    state.speed_step = state.speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE
    base_speed = state.pole_pairs * nameplate.base_speed
    state.weakening_step = 0.02 * CURRENT_SHARE / (base_speed * state.direct_inductance)
    state.speed_integral = state.direct_integral = state.quadrature_integral = state.weakening = 0.0


def step(state, sense, command):
    """Answer for one control period."""
    electrical, angle = state.pole_pairs * sense.speed, state.pole_pairs * sense.angle
    supply = max(sense.supply_voltage, 1e-9)
    limit = supply / ROOT_THREE
    if not sense.enable:
        terminals = sense.phase_voltages[0], sense.phase_voltages[1], sense.phase_voltages[2]
        preload(state, terminals, angle, electrical, supply)
        command.first_duty = command.second_duty = command.third_duty = 0.5
        return
    currents = phase_current(sense, 0), phase_current(sense, 1), phase_current(sense, 2)
    direct, quadrature = park(currents, angle)
    wanted = references(state, sense.reference, sense.speed, electrical, limit)
    error = wanted[0] - direct, wanted[1] - quadrature
    voltage = regulate(state, error, (direct, quadrature), electrical, limit)
    ratios = modulate(voltage, angle + electrical * state.lead, supply)
    command.first_duty, command.second_duty, command.third_duty = ratios
    command.torque = per_ampere(state, direct) * quadrature


@numba.njit
def preload(state, terminals, angle, electrical, supply):
    """Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off."""
    # Terminals at the rail of a conducting diode do not show it.
    if max(terminals) < supply:
        state.direct_integral, induced = park(terminals, angle)
        state.quadrature_integral = induced - electrical * state.flux


@numba.njit
def regulate(state, error, current, electrical, limit):
    """Return the voltage that brings the currents to their references (V), within the limit."""
    # The coupling of the axes and the back-EMF are added in advance.
    direct = (
        state.direct_gain * error[0]
        + state.direct_integral
        - electrical * state.quadrature_inductance * current[1]
    )
    quadrature = (
        state.quadrature_gain * error[1]
        + state.quadrature_integral
        + electrical * (state.direct_inductance * current[0] + state.flux)
    )
    # A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals.
    used = magnitude(direct, quadrature)
    share = limit / max(limit, used)
    cut = share - 1.0
    state.direct_integral += state.direct_step * (error[0] + cut * direct / state.direct_gain)
    state.quadrature_integral += state.quadrature_step * (error[1] + cut * quadrature / state.quadrature_gain)
    # A machine that differs from the nameplate shows in the voltage that is requested.
    weakening = state.weakening + state.weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used)
    state.weakening = between(weakening, -0.3 * state.limit, 0.0)
    return share * direct, share * quadrature


@numba.njit
def references(state, reference, speed, electrical, limit):
    """Return the currents for what the reference requests, as far as the limits allow (A)."""
    error = reference - speed
    integral = state.speed_integral + state.speed_step * error
    torque = reference if state.regulates_torque else state.speed_gain * error + integral
    # Negative where the torque brakes: the drop of the resistance is then against the back-EMF.
    turning = -electrical if torque < 0.0 else electrical
    voltage = VOLTAGE_SHARE * limit
    if not state.regulates_torque and turning < 0.0:
        voltage -= BRAKING_SHARE * limit * min(abs(torque) / (0.2 * state.greatest), 1.0)
    direct = direct_for(state, min(abs(torque), state.greatest), turning, voltage)
    direct = max(direct + state.weakening, state.deepest)
    most = max(possible(state, direct, turning, voltage), 0.0)
    # The integral of the speed waits while the limits allow less than it requests.
    if abs(torque) <= most or torque * error <= 0.0:
        state.speed_integral = integral
    return direct, between(torque, -most, most) / per_ampere(state, direct)


@numba.njit
def direct_for(state, torque, electrical, voltage):
    """Return the direct current (A) for a torque: the least, weakened for the voltage, or that of most torque."""
    direct, deeper, near = least_current(state, torque), state.deepest, 0.001 * state.limit
    if possible(state, direct, electrical, voltage) >= torque:
        return direct
    for _ in range(14):
        middle = 0.5 * (direct + deeper)
        found = possible(state, middle, electrical, voltage)
        if found >= torque or possible(state, middle - near, electrical, voltage) <= found:
            deeper = middle
        else:
            direct = middle
    return deeper


@numba.njit
def possible(state, direct, electrical, voltage):
    """Return the greatest torque at a direct current within both limits (N·m), negative if there is none."""
    headroom = state.limit * state.limit - direct * direct
    along = electrical * (state.direct_inductance * direct + state.flux)
    reactance, resistance = electrical * state.quadrature_inductance, state.resistance
    # The voltage is a quadratic in the quadrature current: a q² + 2 b q + c = 0 at its limit.
    a = reactance * reactance + resistance * resistance
    b = resistance * (along - reactance * direct)
    c = resistance * resistance * direct * direct + along * along - voltage * voltage
    inside = b * b - a * c
    if inside < 0.0:
        return inside
    return per_ampere(state, direct) * min(sqrt(headroom), (sqrt(inside) - b) / a)


@numba.njit
def least_current(state, torque):
    """Return the direct current with which a torque needs the least current (A)."""
    direct = 0.0
    for _ in range(6):
        quadrature = torque / per_ampere(state, direct)
        turned = 2.0 * state.saliency * quadrature
        direct = -turned * quadrature / (state.flux + magnitude(state.flux, turned))
    return direct


@numba.njit
def per_ampere(state, direct):
    """Return the torque of one ampere across the magnet's axis (N·m/A)."""
    return 1.5 * state.pole_pairs * (state.flux - state.saliency * direct)


@numba.njit
def between(value, least, greatest):
    """Return a value within bounds."""
    return min(max(value, least), greatest)


@numba.njit
def magnitude(along, across):
    """Return the length of a vector."""
    return sqrt(along * along + across * across)


@numba.njit
def park(phases, angle):
    """Transform currents (A) or voltages (V) of the phases into the frame of the rotor, by Clarke and Park."""
    first, second, third = phases
    along, across = (2.0 * first - second - third) / 3.0, (second - third) / ROOT_THREE
    return cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along


@numba.njit
def modulate(voltage, angle, supply):
    """Return the duty ratios for a voltage (V), by inverse Park and Clarke, centred in the link by a zero sequence."""
    along = cos(angle) * voltage[0] - sin(angle) * voltage[1]
    across = 0.5 * ROOT_THREE * (sin(angle) * voltage[0] + cos(angle) * voltage[1])
    second, third = across - 0.5 * along, -across - 0.5 * along
    middle = 0.5 * (max(along, second, third) + min(along, second, third))
    return (
        between(0.5 + (along - middle) / supply, 0.0, 1.0),
        between(0.5 + (second - middle) / supply, 0.0, 1.0),
        between(0.5 + (third - middle) / supply, 0.0, 1.0),
    )


controller = NumbaController(STATE, reset=reset, step=step, contract="duty")
