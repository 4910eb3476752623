"""A step of a controller of duty ratios that is shown other senses, and whose answers are changed on the way."""

from __future__ import annotations

from functools import cache
from math import floor, pi
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step, double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE, duty_command_record
from drivegate_models.controllers.duty.position import copy_sense
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine

_TURN = 2.0 * pi
# Sectors of an electrical cycle, by the states of the Hall switches as bits; none for those that they never have.
_SECTORS = (-1, 0, 2, 1, 4, 5, 3, -1)

SPOILT_STATE: Final = np.dtype(
    [
        # The controller itself, and the records below.
        ("step_address", np.int64),
        ("state_address", np.int64),
        ("sense_address", np.int64),
        ("command_address", np.int64),
        ("currents_address", np.int64),
        ("sense", DUTY_SENSE),
        ("command", DUTY_COMMAND),
        ("currents", np.float64, (3,)),
        # What is added to the shaft's angle (rad) and to the first current (A), and what scales other senses (1).
        ("angle_added", np.float64),
        ("current_added", np.float64),
        # What scales the angle (1), after how much of it a counter begins anew (rad; 0 for never), how much has turned
        # since, and the angle of the step before (rad).
        ("angle_factor", np.float64),
        ("wraps_after", np.float64),
        ("turned", np.float64),
        ("angle_before", np.float64),
        # Whether the edges of Hall switches are counted in place of their states being read, and the state before.
        ("counts_edges", np.int64),
        ("hall_before", np.int64),
        # What is added to the current along the magnet's axis (A), and the pole pairs by which it turns.
        ("direct_added", np.float64),
        ("pole_pairs", np.float64),
        ("current_factor", np.float64),
        ("speed_factor", np.float64),
        ("supply_factor", np.float64),
        # Whether the third current is shown as what the other two leave, as it is where there are two sensors, and
        # whether the currents of the step before are shown.
        ("computes_third", np.int64),
        ("is_late", np.int64),
        ("before", np.float64, (3,)),
        # What the duty ratios are stretched by about the middle (1), whether two phases are swapped, and the control
        # period that is asked for over the drive's own (1), 0 for none; and whether each is clamped to its range then.
        ("stretch", np.float64),
        ("clamps", np.int64),
        ("swaps_phases", np.int64),
        ("next_period", np.float64),
    ],
    align=True,
)
"""State of a spoilt controller; what it points to has to outlive it, and it has to stay in its place."""


def spoilt_state(step_address: int, state_address: int, spoilt: dict[str, float]) -> NDArray[Any]:
    """Make the state of a controller that is spoilt.

    Parameters
    ----------
    step_address, state_address : int
        Addresses of the controller's step and of its state.
    spoilt : dict
        Fields of SPOILT_STATE that are not as they should be.

    Returns
    -------
    array of SPOILT_STATE, shape (1,)
        The state.
    """
    state = np.zeros(1, SPOILT_STATE)
    offsets: Any = SPOILT_STATE.fields
    state["step_address"], state["state_address"] = step_address, state_address
    for record in ("sense", "command", "currents"):
        state[f"{record}_address"] = state.ctypes.data + offsets[record][1]
    state["command"] = duty_command_record()
    for name in ("current_factor", "speed_factor", "supply_factor", "angle_factor", "stretch"):
        state[name] = 1.0
    for name, value in spoilt.items():
        state[name] = value
    return state


@inlined
def _wrap_count(state: Any, angle: float) -> None:
    """Let a counter that has come to its end begin anew: what it has lost is missing from the angle from then on."""
    turn = angle - state.angle_before
    state.angle_before = angle
    # Less the whole turn by which the angle itself starts again.
    state.turned += turn - _TURN * floor(turn / _TURN + 0.5)
    if abs(state.turned) >= state.wraps_after:
        lost = state.wraps_after if state.turned > 0.0 else -state.wraps_after
        state.turned -= lost
        state.angle_added -= lost


@inlined
def _count_edge(state: Any, hall: int) -> None:
    """Count an edge as one sector, of however many the state has changed: what it is more is missing from then on."""
    if state.hall_before > 0 and hall != state.hall_before:
        passed = (_SECTORS[hall] - _SECTORS[state.hall_before]) % 6
        state.angle_added -= (passed - 1) * _TURN / 6.0 / state.pole_pairs
    state.hall_before = hall


@inlined
def _stretched(state: Any, ratio: float) -> float:
    """Return a duty ratio as it is answered."""
    stretched = float(0.5 + state.stretch * (ratio - 0.5))
    return min(max(stretched, 0.0), 1.0) if state.clamps == 1 else stretched


@inlined
def _show(state: Any, sense: Any) -> None:
    """Write what the controller is shown."""
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    added = RotorFrame(state.direct_added, 0.0, cosine, sine)
    for phase in range(3):
        seen = state.current_factor * double_at(sense.phase_currents, phase) + phase_current(added, phase)
        if phase == 0:
            seen += state.current_added
        state.currents[phase] = state.before[phase] if state.is_late == 1 else seen
        state.before[phase] = seen
    if state.computes_third == 1:
        state.currents[2] = -state.currents[0] - state.currents[1]
    shown = state.sense
    copy_sense(sense, shown)
    shown.phase_currents = state.currents_address
    shown.supply_voltage = state.supply_factor * sense.supply_voltage
    if state.wraps_after > 0.0:
        _wrap_count(state, sense.angle)
    if state.counts_edges == 1 and sense.hall > 0:
        _count_edge(state, sense.hall)
    shown.angle = state.angle_factor * sense.angle + state.angle_added
    shown.speed = state.speed_factor * sense.speed


@inlined
def _tell(state: Any, command: Any) -> None:
    """Write what is answered in place of what the controller has said."""
    said = state.command
    command.first_duty = _stretched(state, said.first_duty)
    command.second_duty = _stretched(state, said.second_duty)
    command.third_duty = _stretched(state, said.third_duty)
    if state.swaps_phases == 1:
        second = command.second_duty
        command.second_duty = command.third_duty
        command.third_duty = second
    command.first_leg = said.first_leg
    command.second_leg = said.second_leg
    command.third_leg = said.third_leg
    command.next_period = state.next_period
    command.torque = said.torque
    command.angle = said.angle
    command.speed = said.speed
    command.input_power = said.input_power
    command.fault = said.fault


@inlined
def step_spoilt(state: Any, sense: Any, command: Any) -> None:
    """Answer for one control period as the controller would that sees and says something else."""
    _show(state, sense)
    call_step(state.step_address, state.state_address, state.sense_address, state.command_address)
    _tell(state, command)


@cache
def spoilt_step_function() -> Any:
    """Return the step of a spoilt controller, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a C function whose state is a SPOILT_STATE; keep the object.
    """
    signature = step_signature(SPOILT_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_spoilt(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)
