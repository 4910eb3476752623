"""The built-in controllers `initial`, `published` and `reference` with the native interface (Fig. 2).

One step function serves all three. They differ in the constants that their resets write into the state.
"""

from __future__ import annotations

from functools import cache
from math import inf, pi, radians
from types import MappingProxyType
from typing import Any, Final

import numba
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.controllers.current.flowchart_search import decide_by_flowchart, decide_guarded
from drivegate_models.controllers.current.following import follow_speed, reset_following
from drivegate_models.controllers.current.modes import is_following, rearm
from drivegate_models.controllers.current.protection import guard_regulation
from drivegate_models.controllers.current.regulator_rates import (
    BANDWIDTH,
    FASTEST_OF_FREQUENCY,
    INTEGRAL_RATE,
    TUNED_FREQUENCY,
    TUNED_TIME,
)
from drivegate_models.controllers.current.state import CONTROLLER_STATE, FLOWCHART, GUARDED, NO_SEARCH
from drivegate_models.units import RADIANS_PER_RPM

SEARCH_PERIOD: Final = 0.1
"""Time between decisions of the search (s). For the guarded search, at the electrical frequency it is tuned for."""

SEARCHES: Final = MappingProxyType({"initial": NO_SEARCH, "published": FLOWCHART, "reference": GUARDED})

# Upper limit of the scale of times and rates: the rate that a control period can follow (s).
_FASTEST = 1e-3
# Greatest rates of a light shaft, over those of the drive tuned on.
_FASTEST_REGULATOR = 2.0
# k1 of Fig. 4: the value of the flowchart (rad/s), and a share of base speed for the guarded search.
_FLOWCHART_TOLERANCE = 5.0 * RADIANS_PER_RPM
_SPEED_TOLERANCE = 0.01
# Noise of the current sum by the converter, as a share of the current limit.
_LEAST_CHANGE = 0.0008
# Share of base speed. Without it, regulation at base speed would switch the jump of the angle on and off.
_ADVANCE_MARGIN = 0.02


@inlined
def reset_state(state: Any, nameplate: Any, search: int) -> None:
    """Write the constants of a controller and reset everything else.

    `search` is `NO_SEARCH`, `FLOWCHART` or `GUARDED`.
    """
    published = search == FLOWCHART
    rate = nameplate.pole_pairs * nameplate.base_speed / TUNED_FREQUENCY
    rate = min(rate, _FASTEST / nameplate.control_period)
    state.search = search
    state.angle_at_base = nameplate.advance_start
    state.angle_slope = nameplate.advance_slope
    if published:
        # The line of Fig. 3 starts from zero. Here it ends where the nameplate's line ends; in between it cannot reach
        # rated power.
        state.angle_at_base = 0.0
        state.angle_slope += nameplate.advance_start / (nameplate.highest_speed - nameplate.base_speed)
    state.base_speed = nameplate.base_speed
    margin = _ADVANCE_MARGIN * nameplate.base_speed if search == GUARDED else 0.0
    state.advance_begins = nameplate.base_speed + margin
    state.nominal_voltage = nameplate.half_supply_voltage
    state.current_limit = nameplate.current_limit
    state.rated_sum = nameplate.rated_power / nameplate.half_supply_voltage
    state.control_period = nameplate.control_period
    state.paced_period = nameplate.control_period * rate
    state.window = nameplate.window
    state.conducting_phases = nameplate.conducting_phases
    torque_per_ampere = state.conducting_phases * nameplate.emf_constant
    sooner = (
        TUNED_TIME * nameplate.rated_power / (nameplate.inertia * nameplate.base_speed * nameplate.base_speed)
    )
    regulation = max(rate, min(sooner, FASTEST_OF_FREQUENCY * rate, _FASTEST_REGULATOR))
    state.proportional = nameplate.inertia * (BANDWIDTH * regulation) / torque_per_ampere
    state.integral_step = state.proportional * (INTEGRAL_RATE * regulation) * nameplate.control_period
    reset_following(state, nameplate, rate, regulation, sooner / TUNED_TIME)
    # k1 and k2 of Fig. 4.
    state.speed_tolerance = _FLOWCHART_TOLERANCE if published else _SPEED_TOLERANCE * nameplate.base_speed
    state.power_tolerance = 0.001
    state.least_change = _LEAST_CHANGE * nameplate.current_limit
    state.first_step = radians(1.0)
    state.tries_again = 1
    period = state.control_period if published else state.paced_period
    state.decision_steps = max(round(SEARCH_PERIOD / period), 1)
    state.integral = 0.0
    state.advancing = 0
    state.held_power = 0.0
    state.rest_power = 0.0
    state.speed_reference = -inf
    state.supply_voltage = nameplate.half_supply_voltage
    state.speed_mark = 0.0
    state.good_offset = 0.0
    state.last_power = 0.0
    state.last_integral = 0.0
    state.integral_growth = 0.0
    state.winding = 0
    state.error = 0.0
    rearm(state)


@inlined
def line_speed(state: Any, speed: float) -> float:
    """Return the speed (rad/s) at which the angle model is evaluated, for a measured speed above base speed.

    For the guarded search it is the speed of the same EMF relative to supply at nominal voltage.
    """
    if state.search == GUARDED and state.supply_voltage > 0.0:
        # The feasible edge depends on EMF over supply. The stored voltage excludes sensor noise from the angle.
        scaled: float = max(speed * state.nominal_voltage / state.supply_voltage, state.base_speed)
        return scaled
    return speed


@inlined
def line_angle(state: Any, speed: float) -> float:
    """Return the initial angle (rad electrical), to which the search adds its offset, above base speed (rad/s)."""
    return initial_angle(line_speed(state, speed), state.base_speed, state.angle_at_base, state.angle_slope)


@inlined
def advance_angle(state: Any, speed: float) -> float:
    """Return the advance angle (rad electrical) at a measured speed (rad/s).

    It is the initial angle plus the search's offset, and zero below base speed.
    """
    if speed < state.base_speed:
        state.advancing = 0
        return 0.0
    if state.advancing == 0:
        if speed < state.advance_begins:
            return 0.0
        state.advancing = 1
    applied: float = min(max(line_angle(state, speed) + state.offset, 0.0), 0.5 * pi)
    return applied


@inlined
def current_reference(state: Any, sense: Any) -> float:
    """Regulate the speed, and return the current reference (A)."""
    if is_following(state):
        return follow_speed(state, sense.speed_reference - sense.speed, sense.speed)
    reference, integral = regulate_speed(
        sense.speed_reference - sense.speed,
        state.integral,
        state.proportional,
        state.integral_step,
        state.current_limit,
    )
    state.integral = integral
    return reference


@inlined
def observe(state: Any, sense: Any, reference: float) -> bool:
    """Add a control period to the decision interval, and return True if a decision is due.

    `reference` is the current reference (A).
    """
    state.count += 1
    state.power_sum += sense.current_magnitude_sum
    state.error = sense.speed_reference - sense.speed
    state.worst_error = max(state.worst_error, abs(state.error))
    if reference >= state.current_limit:
        state.saturated += 1
    if state.search == GUARDED:
        guard_regulation(
            state,
            sense.speed,
            sense.speed_reference,
            sense.half_supply_voltage,
            sense.current_magnitude_sum,
            reference,
            state.paced_period,
        )
    due: bool = state.count >= state.decision_steps
    return due


@inlined
def begin_interval(state: Any) -> None:
    state.count = 0
    state.power_sum = 0.0
    state.worst_error = 0.0
    state.saturated = 0


@inlined
def search(state: Any, sense: Any, reference: float) -> None:
    """Make one step of the search: observe, and decide when a decision is due.

    `reference` is the current reference (A).
    """
    if observe(state, sense, reference):
        if state.search == FLOWCHART:
            decide_by_flowchart(state, sense.speed_reference - sense.speed)
        else:
            state.lowest = -line_angle(state, max(sense.speed, state.base_speed))
            state.emf_over_supply = line_speed(state, sense.speed) / state.matched_speed
            decide_guarded(state)
        begin_interval(state)


@inlined
def write_command(state: Any, sense: Any, reference: float, command: Any) -> None:
    """Write the command: current reference (A), advance angle (rad electrical) and estimated input power (W)."""
    command.current_reference = reference
    command.advance_angle = advance_angle(state, sense.speed)
    command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum


@inlined
def step_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period."""
    reference = current_reference(state, sense)
    if state.search != NO_SEARCH and state.advancing == 1:
        search(state, sense, reference)
    write_command(state, sense, reference, command)


@cache
def step_function() -> Any:
    """Return the built-in controllers' `drivegate_step`, compiled.

    Its `address` is that of a C function. The caller must retain the object.
    """
    signature = step_signature(CONTROLLER_STATE, SENSE, COMMAND)

    def drivegate_step(state: Any, sense: Any, command: Any) -> None:
        step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_step)


@cache
def reset_function() -> Any:
    """Return the compiled function that resets a built-in controller.

    Its arguments are the state, shape (1,) of CONTROLLER_STATE, the nameplate, shape (1,) of NAMEPLATE, and the search.
    """

    def reset(state: Any, nameplate: Any, search: int) -> None:
        reset_state(state[0], nameplate[0], search)

    return numba.njit(cache=KEEPS_CACHE)(reset)


@inlined
def regulate_speed(
    error: float, integral: float, proportional: float, integral_step: float, limit: float
) -> tuple[float, float]:
    """Return the current reference, from 0 to `limit`, and the new integral (A): the PI regulator of Fig. 2.

    `error` is speed reference minus speed (rad/s), `proportional` the gain, and `integral_step` the integral gain times
    the control period (both A s/rad). The integral stays constant while the output is limited in the error's direction.
    """
    following = min(max(integral + integral_step * error, 0.0), limit)
    reference = proportional * error + following
    # At a limit the integral may only decrease in magnitude; otherwise the speed overshoots until it is unwound.
    if reference > limit:
        return limit, min(integral, following) if error > 0.0 else following
    if reference < 0.0:
        return 0.0, max(integral, following) if error < 0.0 else following
    return reference, following


@inlined
def initial_angle(speed: float, base_speed: float, angle_at_base: float, slope: float) -> float:
    """Return the initial advance angle (rad electrical), limited to 0 to 90 degrees.

    Below `base_speed` (rad/s) it is zero. Above, it starts at `angle_at_base` (rad electrical; 0 in the paper's Fig. 3)
    and rises by `slope` (rad electrical per rad/s).
    """
    if speed < base_speed:
        return 0.0
    return min(max(angle_at_base + slope * (speed - base_speed), 0.0), 1.5707963267948966)
