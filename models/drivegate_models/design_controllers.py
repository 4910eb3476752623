"""Correct controllers of other designs than the reference, behind the native interface.

All share regulator, angle model, regulation guard and the way an angle is tried; they differ in which angle comes
next. The harness tests itself with them: it must accuse none.
"""

from __future__ import annotations

from functools import cache
from math import inf, pi, radians
from types import MappingProxyType
from typing import Any, Final

import numba
from numba import types
from numba.np.numpy_support import carray

from drivegate_models.angle_model import initial_angle
from drivegate_models.angle_movement import ABSORB, BEGIN, DOWNWARD, go_to, rest_at_best, restart
from drivegate_models.angle_probe import probe_angle
from drivegate_models.angle_sweep import begin_sweep, continue_sweep, sample_sweep, sweep_rate
from drivegate_models.angle_table import look_up
from drivegate_models.compilation import KEEPS_CACHE, unfused
from drivegate_models.contract import COMMAND, SENSE
from drivegate_models.design_state import (
    ANGLE_TABLE,
    DESIGN_STATE,
    GOLDEN_SECTION,
    MARGIN,
    MOVING,
    QUADRATIC_INTERPOLATION,
    RESTING,
    SLOPE_BISECTION,
    SWEEP,
)
from drivegate_models.golden_section import begin_golden_section, continue_golden_section
from drivegate_models.quadratic_interpolation import (
    begin_quadratic_interpolation,
    continue_quadratic_interpolation,
)
from drivegate_models.regulation_guard import UNEASY, believe_sensors, watch_regulation
from drivegate_models.regulation_recovery import respond
from drivegate_models.slope_bisection import begin_slope_bisection, continue_slope_bisection
from drivegate_models.speed_regulator import regulate_speed

DESIGNS: Final = MappingProxyType(
    {
        "golden-section": GOLDEN_SECTION,
        "quadratic-interpolation": QUADRATIC_INTERPOLATION,
        "angle-table": ANGLE_TABLE,
        "sweep": SWEEP,
        "slope-bisection": SLOPE_BISECTION,
    }
)
"""Number of a design by its name."""

_ANGLE_AT_BASE = radians(33.0)
_ANGLE_SLOPE = radians(0.025) * 30.0 / pi
_BANDWIDTH = 150.0
_INTEGRAL_RATE = 30.0
_STARVING_SHARE = 0.065
_LONGEST_STARVING = 0.05
_SPARE_TORQUE = 0.005
_CALM_GAIN = 0.5
_ADVANCE_MARGIN = 10.0 * pi / 30.0
_HIGHEST_AT_BASE = radians(46.0)
_HIGHEST_SLOPE = radians(0.08) * 30.0 / pi
_HIGHEST = radians(72.0)


@unfused
def reset_design(state: Any, nameplate: Any, design: int) -> None:
    """Write the constants of a design and forget everything else.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Overwritten.
    nameplate : record of NAMEPLATE
        The drive's nominal data.
    design : int
        One of `DESIGNS`.
    """
    state.design = design
    state.base_speed = nameplate.base_speed
    state.advance_begins = nameplate.base_speed + _ADVANCE_MARGIN
    state.nominal_voltage = nameplate.half_supply_voltage
    state.current_limit = nameplate.current_limit
    state.control_period = nameplate.control_period
    torque_per_ampere = 0.8 * nameplate.phases * nameplate.emf_constant
    state.proportional = nameplate.inertia * _BANDWIDTH / torque_per_ampere
    state.integral_step = state.proportional * _INTEGRAL_RATE * nameplate.control_period
    # A heavy shaft shows later that it lacks torque.
    rated_torque = nameplate.rated_power / nameplate.base_speed
    run_up = nameplate.inertia * nameplate.base_speed / rated_torque
    state.starving_dwell = min(_STARVING_SHARE * run_up, _LONGEST_STARVING)
    state.slowest_regain = _SPARE_TORQUE * rated_torque / nameplate.inertia
    state.speed = -inf
    state.voltage = nameplate.half_supply_voltage
    state.current_sum = 0.0
    # The first values are believed, whatever they are.
    state.speed_doubted = 1 << 30
    state.voltage_doubted = 0
    state.current_doubted = 0
    state.blind = 0
    state.integral = 0.0
    state.advancing = 0
    state.line = 0.0
    state.speed_reference = -inf
    state.supply = nameplate.half_supply_voltage
    state.error = 0.0
    state.alarm_run = 0
    state.saturated_run = 0
    state.speed_mark = 0.0
    state.good_offset = 0.0
    state.good_integral = 0.0
    state.offset = 0.0
    state.home = 0.0
    state.home_power = 0.0
    state.home_ratio = inf
    state.home_error = 0.0
    state.best_offset = 0.0
    state.best_power = 0.0
    state.held_power = 0.0
    state.first_held_power = 0.0
    state.held_integral = 0.0
    state.finished = 0
    state.stage = 0
    state.probes = 0
    restart(state)


@unfused
def begin_search(state: Any) -> float:
    """Let the design choose its first angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.design == GOLDEN_SECTION:
        return begin_golden_section(state)
    if state.design == QUADRATIC_INTERPOLATION:
        return begin_quadratic_interpolation(state)
    if state.design == ANGLE_TABLE:
        return look_up(state, state.home_power)
    if state.design == SWEEP:
        return begin_sweep(state)
    return begin_slope_bisection(state)


@unfused
def continue_search(state: Any, power: float) -> float:
    """Let the design choose its next angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.design == GOLDEN_SECTION:
        return continue_golden_section(state, power)
    if state.design == QUADRATIC_INTERPOLATION:
        return continue_quadratic_interpolation(state, power)
    if state.design == ANGLE_TABLE:
        return look_up(state, power)
    if state.design == SWEEP:
        return continue_sweep(state)
    return continue_slope_bisection(state, power)


@unfused
def conduct_search(state: Any, work: int) -> None:
    """Send the angle where the design wants it, or to rest; what is forbidden needs no probe.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    work : int
        `BEGIN` or `ABSORB`.
    """
    wanted = begin_search(state) if work == BEGIN else continue_search(state, state.old_power)
    while state.finished == 0 and state.design != SWEEP and wanted < state.forbidden + MARGIN:
        wanted = continue_search(state, inf)
    if state.finished == 1:
        rest_at_best(state)
    else:
        go_to(state, wanted, sweep_rate(state) if state.design == SWEEP else DOWNWARD)


@unfused
def advance_design(state: Any, speed: float) -> float:
    """Return the advance angle: the initial one plus the offset, zero below base speed.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    speed : float
        Measured speed (rad/s), believed or not.

    Returns
    -------
    float
        Angle (rad electrical).
    """
    if state.speed < state.base_speed:
        state.advancing = 0
    elif state.advancing == 0 and state.speed >= state.advance_begins:
        state.advancing = 1
        restart(state)
        state.offset = state.home
    if state.advancing == 0 or speed < state.base_speed:
        return 0.0
    # The same EMF over supply: the line follows the measured supply.
    line_speed = max(state.speed * state.nominal_voltage / state.voltage, state.base_speed)
    state.line = initial_angle(line_speed, state.base_speed, _ANGLE_AT_BASE, _ANGLE_SLOPE)
    applied: float = min(max(state.line + state.offset, 0.0), 0.5 * pi)
    return applied


@unfused
def step_design(state: Any, sense: Any, command: Any) -> None:
    """Answer for one control period.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    sense : record of SENSE
        What the sensors saw.
    command : record of COMMAND
        Receives the answer.
    """
    believe_sensors(state, sense.speed, sense.half_supply_voltage, sense.current_magnitude_sum)
    # At rest a calmer regulator passes less of the sensors' noise on to the current.
    arrived = state.mode == RESTING and state.offset == state.target
    calm = arrived and abs(state.error) < UNEASY
    gain = _CALM_GAIN if calm else 1.0
    reference, integral = regulate_speed(
        sense.speed_reference - state.speed,
        state.integral,
        gain * state.proportional,
        gain * gain * state.integral_step,
        state.current_limit,
    )
    state.integral = integral
    saturated = reference >= state.current_limit
    report = watch_regulation(state, sense.speed_reference, saturated)
    if state.advancing == 1:
        highest = min(_HIGHEST_AT_BASE + _HIGHEST_SLOPE * max(state.speed - state.base_speed, 0.0), _HIGHEST)
        respond(state, report, highest - state.line)
        work = probe_angle(state, saturated)
        if state.design == SWEEP and state.mode == MOVING:
            sample_sweep(state)
        if work in (BEGIN, ABSORB):
            conduct_search(state, work)
    command.current_reference = reference
    command.advance_angle = advance_design(state, sense.speed)
    command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum


def _record_pointer(layout: Any) -> Any:
    pointer: Any = types.CPointer
    return pointer(numba.from_dtype(layout))


@cache
def design_step_function() -> Any:
    """Return the designs' `drivegate_step`, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a C function; keep the object.
    """
    signature = types.void(_record_pointer(DESIGN_STATE), _record_pointer(SENSE), _record_pointer(COMMAND))

    def drivegate_step(state: Any, sense: Any, command: Any) -> None:
        step_design(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_step)


@cache
def design_reset_function() -> Any:
    """Return the function that resets a design, compiled.

    Returns
    -------
    Dispatcher
        Takes the state, shape (1,) of DESIGN_STATE, the nameplate, shape (1,) of NAMEPLATE, and the design.
    """

    def reset(state: Any, nameplate: Any, design: int) -> None:
        reset_design(state[0], nameplate[0], design)

    return numba.njit(cache=KEEPS_CACHE)(reset)
