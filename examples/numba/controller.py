"""The controller of ../python, compiled by numba: its state is a record, and its methods are functions of it."""

from typing import Any

import numba
import numpy as np

from drivegate import NumbaController

DEGREE = 0.017453292519943295

INTERVAL = 57.5  # rad at base speed: the search decides once in this time
PATIENCE = 4.6  # rad at base speed: a speed that stays behind for so long has lost its torque
CALM = 0.003  # of base speed
CREEPING = 0.0014  # of base speed
MARGIN = 0.02  # of base speed: how far above it the advance begins
FIRST_STEP = 2.0 * DEGREE
LAST_STEP = 0.7 * DEGREE
HIGHEST = 24.0 * DEGREE
NOWHERE = -90.0 * DEGREE

WAITING, SEARCHING, RECOVERING, RESTING = range(4)

REALS = (
    *("limit", "base_speed", "nominal_voltage", "period", "gain", "integral_step", "integral"),
    *("interval", "patience", "calm", "creeping", "advance_begins", "line_start", "line_slope"),
    *("speed_reference", "speed_mark", "current_sum", "worst_error", "last_current"),
    *("offset", "step_size", "lost_offset", "best_offset", "best_current", "best_integral"),
)
INTEGERS = ("advancing", "phase", "intervals", "steps", "moves", "escapes", "strained")
STATE = np.dtype([(name, np.float64) for name in REALS] + [(name, np.int64) for name in INTEGERS])


def reset(state: Any, nameplate: Any) -> None:
    """Prepare for a run, and forget all earlier ones."""
    state.limit = nameplate.current_limit
    state.base_speed = nameplate.base_speed
    state.nominal_voltage = nameplate.half_supply_voltage
    state.period = nameplate.control_period
    frequency = nameplate.pole_pairs * nameplate.base_speed
    bandwidth = frequency / 7.2
    state.interval = INTERVAL / frequency
    state.patience = PATIENCE / frequency
    state.calm = CALM * nameplate.base_speed
    state.creeping = CREEPING * nameplate.base_speed
    state.advance_begins = nameplate.base_speed + MARGIN * nameplate.base_speed
    state.line_start = nameplate.advance_start
    state.line_slope = nameplate.advance_slope
    state.gain = bandwidth * nameplate.inertia / (nameplate.conducting_phases * nameplate.emf_constant)
    state.integral_step = 0.1875 * bandwidth * state.gain * nameplate.control_period
    state.integral = 0.0
    state.speed_reference = -1.0
    state.advancing = 0
    state.strained = 0
    state.speed_mark = 0.0
    state.step_size = 0.0
    state.moves = 0
    state.escapes = 0
    state.offset = 0.0
    state.best_offset = 0.0
    state.best_current = 0.0
    state.best_integral = 0.0
    begin_anew(state)


def step(state: Any, sense: Any, command: Any) -> None:
    """Answer for one control period."""
    error = sense.speed_reference - sense.speed
    reference = regulate(state, error)
    command.current_reference = reference
    command.advance_angle = 0.0
    command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum
    if sense.speed_reference != state.speed_reference:
        state.speed_reference = sense.speed_reference
        state.offset = 0.0
        begin_anew(state)
    if sense.speed < state.base_speed:
        state.advancing = 0
    elif sense.speed >= state.advance_begins:
        state.advancing = 1
    if state.advancing == 0:
        return

    state.worst_error = max(state.worst_error, abs(error))
    state.current_sum += sense.current_magnitude_sum
    state.steps += 1
    if has_lost_torque(state, error, reference, sense.speed):
        regain_torque(state)
    elif state.steps * state.period >= state.interval:
        end_interval(state)
    command.advance_angle = advance_angle(state, sense.speed, sense.half_supply_voltage)


@numba.njit
def regulate(state: Any, error: float) -> float:
    """Return the current reference: a PI regulator whose integral waits while the output is limited."""
    integral = state.integral + state.integral_step * error
    reference = state.gain * error + integral
    output = min(max(reference, 0.0), state.limit)
    if output == reference:
        state.integral = integral
    return output


@numba.njit
def advance_angle(state: Any, speed: float, voltage: float) -> float:
    """Return the initial line over speed, at the same EMF over supply, plus the search's offset."""
    if voltage > 1.0:
        speed = speed * state.nominal_voltage / voltage
    line = state.line_start + state.line_slope * (speed - state.base_speed)
    return min(max(line + state.offset, 0.0), 90.0 * DEGREE)


@numba.njit
def begin_anew(state: Any) -> None:
    """Begin a new search, with nothing known of the edge where the torque is lost."""
    state.lost_offset = NOWHERE
    enter(state, WAITING)
    state.last_current = 0.0


@numba.njit
def enter(state: Any, phase: int) -> None:
    """Enter a phase of the search."""
    state.phase = phase
    state.intervals = 0
    begin_interval(state)


@numba.njit
def begin_interval(state: Any) -> None:
    """Begin to take the mean of Σ|i|."""
    state.steps = 0
    state.current_sum = 0.0
    state.worst_error = 0.0


@numba.njit
def end_interval(state: Any) -> None:
    """Decide on the angle from the mean of Σ|i| over the interval."""
    current = state.current_sum / state.steps
    error = state.worst_error
    change = abs(current - state.last_current)
    state.intervals += 1
    begin_interval(state)
    if state.phase == WAITING:
        state.last_current = current
        if state.intervals >= 2 and error <= state.calm and change <= 0.004 * current:
            keep(state, current)
            state.moves = 0
            state.step_size = -FIRST_STEP
            try_next(state)
    elif state.phase == SEARCHING:
        if state.intervals >= 2:
            judge(state, current, error)
    elif state.phase == RECOVERING:
        if error <= state.calm:
            try_next(state)
        elif state.intervals >= 3:
            # The best angle so far keeps the torque for a while only.
            state.lost_offset = state.best_offset
            state.best_offset = state.best_offset + FIRST_STEP
            state.offset = state.best_offset
            unwind(state)
            enter(state, RECOVERING)
    elif state.intervals < 3:
        state.last_current = current
    elif abs(current - state.best_current) > 0.05 * state.best_current:
        begin_anew(state)
    elif state.intervals < 25 and change > 0.003 * state.last_current:
        # Restless, so too near to the edge.
        state.offset = state.offset + 0.5 * DEGREE
        enter(state, RESTING)


@numba.njit
def judge(state: Any, current: float, error: float) -> None:
    """Keep the angle that was tried if Σ|i| is less there and the regulator does not creep up."""
    creeps = error >= state.creeping and state.integral >= 1.02 * state.best_integral
    if current < 0.999 * state.best_current and not creeps:
        keep(state, current)
        state.moves += 1
    elif state.moves == 0 and state.step_size == -FIRST_STEP:
        state.step_size = 0.5 * FIRST_STEP
    else:
        state.step_size = 0.5 * state.step_size
    try_next(state)


@numba.njit
def keep(state: Any, current: float) -> None:
    """Note the present angle as the best one."""
    state.best_current = current
    state.best_offset = state.offset
    state.best_integral = state.integral


@numba.njit
def try_next(state: Any) -> None:
    """Go one step on from the best angle, by half a step where more loses the torque; or rest there."""
    following = state.best_offset + state.step_size
    if following <= state.lost_offset:
        state.step_size = 0.5 * state.step_size
        following = state.best_offset + state.step_size
    if abs(state.step_size) < LAST_STEP or following <= state.lost_offset:
        state.offset = state.best_offset
        state.escapes = 0
        enter(state, RESTING)
    else:
        state.offset = following
        enter(state, SEARCHING)


@numba.njit
def has_lost_torque(state: Any, error: float, reference: float, speed: float) -> bool:
    """Return whether the speed has stayed behind for some time, or does not rise at the current limit."""
    settled = state.phase == SEARCHING or state.phase == RESTING
    strained = error > state.calm if settled else reference >= state.limit
    state.strained = state.strained + 1 if strained else 0
    if state.strained == 1:
        state.speed_mark = speed
    if state.strained * state.period < state.patience:
        return False
    state.strained = 0
    return settled or speed <= state.speed_mark


@numba.njit
def regain_torque(state: Any) -> None:
    """Go back from the edge of what the angle allows."""
    if state.phase == SEARCHING:
        state.lost_offset = state.offset
        state.step_size = 0.5 * state.step_size
        state.offset = state.best_offset + FIRST_STEP
        unwind(state)
        enter(state, RECOVERING)
    elif state.phase == RESTING and state.intervals < 3 and state.escapes < 2:
        state.escapes += 1
        state.offset = state.offset + 0.5 * DEGREE
        unwind(state)
        enter(state, RESTING)
    else:
        # The load has risen, or the initial line is too low.
        within = state.offset >= 0.0 and state.offset < HIGHEST
        state.offset = state.offset + FIRST_STEP if within else 0.0
        enter(state, WAITING)


@numba.njit
def unwind(state: Any) -> None:
    """Take back what the integral has wound up in vain."""
    state.integral = min(state.integral, 1.02 * state.best_integral)


controller = NumbaController(STATE, reset=reset, step=step)
