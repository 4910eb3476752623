"""A speed regulator, and an advance angle that rises with speed by a straight line; compiled by numba."""

from math import pi

import numba
import numpy as np

from drivegate import NumbaController

# All that the controller remembers. Nothing else lasts from one step to the next.
STATE = np.dtype(
    [
        ("proportional", np.float64),
        ("integral_step", np.float64),
        ("limit", np.float64),
        ("base_speed", np.float64),
        ("advance_start", np.float64),
        ("advance_slope", np.float64),
        ("integral", np.float64),
    ]
)


def reset(state, nameplate):
    """Prepare for a run: called before every one, and must set every field."""
    # The torque that one ampere gives (N·m/A).
    torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant
    # The speed follows its reference with 80 rad/s, and the integral with 15 rad/s, on a drive of 576 rad/s
    # electrical at base speed; on others in proportion.
    rate = nameplate.pole_pairs * nameplate.base_speed / 575.9586531581288
    state.proportional = nameplate.inertia * (80.0 * rate) / torque_per_ampere
    state.integral_step = state.proportional * (15.0 * rate) * nameplate.control_period
    state.limit = nameplate.current_limit
    state.base_speed = nameplate.base_speed
    state.advance_start = nameplate.advance_start
    state.advance_slope = nameplate.advance_slope
    state.integral = 0.0


def step(state, sense, command):
    """Answer for one control period; all quantities are in SI units."""
    command.current_reference = regulate(state, sense.speed_reference - sense.speed)
    command.advance_angle = angle(state, sense.speed)
    # An estimate of the input power; leave it out if the controller makes none.
    command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum


@numba.njit
def regulate(state, error):
    """Return the current reference (A); the integral waits while the limits leave nothing to do."""
    integral = state.integral + state.integral_step * error
    reference = state.proportional * error + integral
    limited = min(max(reference, 0.0), state.limit)
    if limited == reference:
        state.integral = integral
    return limited


@numba.njit
def angle(state, speed):
    """Return the advance angle (rad, electrical). Below base speed it must be 0 exactly (check ADV-1)."""
    if speed < state.base_speed:
        return 0.0
    # Your search for the angle of least input power would add its own part here (check CNV-2).
    line = state.advance_start + state.advance_slope * (speed - state.base_speed)
    return min(max(line, 0.0), 0.5 * pi)


controller = NumbaController(STATE, reset=reset, step=step)
