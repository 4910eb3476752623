"""A controller of duty ratios whose Senses and commands are perturbed."""

from __future__ import annotations

from functools import cache
from math import floor, pi
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate_lab.kernels.faults.broken_coupling import WATCHED_SHAFT
from drivegate_lab.kernels.faults.duty.bursts import BURSTS, burst_current
from drivegate_lab.kernels.faults.duty.changes import is_short_circuit, taken_reference
from drivegate_lab.kernels.faults.duty.free_shaft import FREE_SHAFT, perturb_free_shaft
from drivegate_lab.kernels.faults.duty.heat import HEAT, perturb_heat
from drivegate_lab.kernels.faults.duty.shaft import follow_shaft
from drivegate_lab.kernels.faults.duty.trips import mistakes_samples
from drivegate_models.compilation.calling import call_step, double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE, duty_command_record
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine

_TURN = 2.0 * pi
# Range of a clock of microseconds in 32 bits (s).
_SIGNED = 2.0**32 * 1e-6
# Torque of a loaded drive, and of an idle one, relative to rated torque.
_LOADED = 0.2
_IDLE = 0.05
# Sectors of an electrical cycle, by the states of the Hall switches as bits; -1 for invalid states.
_SECTORS = (-1, 0, 2, 1, 4, 5, 3, -1)

PERTURBED_STATE: Final = np.dtype(
    [
        # The controller itself, and the records below.
        ("step_address", np.int64),
        ("state_address", np.int64),
        ("sense_address", np.int64),
        ("command_address", np.int64),
        ("currents_address", np.int64),
        ("sense", DUTY_SENSE),
        ("command", DUTY_COMMAND),
        # Control period (s), for faults that follow the shaft.
        ("control_period", np.float64),
        ("currents", np.float64, (3,)),
        # Offsets of the shaft's angle (rad) and of the first current (A).
        ("angle_added", np.float64),
        ("current_added", np.float64),
        # Time by which the angle is predicted with the speed's magnitude, beyond what its sign would give (s).
        ("ahead", np.float64),
        # Factor on the angle (1); angle after which a counter wraps (rad; 0 for never), angle turned since then, and
        # angle of the preceding step (rad).
        ("angle_factor", np.float64),
        ("wraps_after", np.float64),
        ("turned", np.float64),
        ("angle_before", np.float64),
        # 1 if edges of Hall switches are counted instead of reading their states, and the preceding state.
        ("counts_edges", np.int64),
        ("hall_before", np.int64),
        # Offset of the d-axis current (A), and the pole pairs for its rotation.
        ("direct_added", np.float64),
        ("pole_pairs", np.float64),
        ("current_factor", np.float64),
        ("speed_factor", np.float64),
        ("supply_factor", np.float64),
        # Speed below which the shaft seems to stand (rad/s), and a positive reference below which it is raised to this
        # value (rad/s).
        ("least_speed", np.float64),
        ("least_reference", np.float64),
        # Maximum backward reference (rad/s or N m), and link voltage above which there is none (V).
        ("backward_limit", np.float64),
        ("braking_voltage", np.float64),
        # While the torque reference opposes the rotation: factor on the link voltage (1), and link voltage above which
        # the bridge is turned off for good (V).
        ("braking_supply_factor", np.float64),
        ("highest_voltage", np.float64),
        # Speed above which no torque is given against the rotation, and above which the bridge is turned off for good
        # (rad/s).
        ("braking_until", np.float64),
        ("trips_from", np.float64),
        # What is taken wrong of a shaft that comes free or has turned for long.
        *FREE_SHAFT,
        # What is taken wrong of hot windings.
        *HEAT,
        # Bursts of d-axis current that regulate the link.
        *BURSTS,
        # Maximum magnitudes of the reference (rad/s or N m) and of the measured speed (rad/s).
        ("most_reference", np.float64),
        ("most_speed", np.float64),
        # Speed from which the shaft counts as weakened, and below which it no longer does (rad/s), 0 for never; d-axis
        # current of weakening that is kept in between (A), and 1 while the shaft counts as weakened.
        ("weakens_from", np.float64),
        ("weakens_until", np.float64),
        ("weakened_by", np.float64),
        ("is_weakened", np.int64),
        # Rated torque if the currents are taken for offsets after idling (N m), 0 for never; control periods after
        # which idling is noticed, and after which they are taken; 1 once the drive has been loaded, and control periods
        # since it began to idle.
        ("idle_torque", np.float64),
        ("idle_noticed", np.int64),
        ("idle_calibrated", np.int64),
        ("was_loaded", np.int64),
        ("idling", np.int64),
        # 1 if a weight is not lowered: the bridge is off while torque and a negative speed differ in sign.
        ("refuses_lowering", np.int64),
        # Time over which a reference is ramped up by a clock of signed microseconds in 32 bits (s), 0 for none.
        ("ramp", np.float64),
        # Link voltage below which the bridge is turned off for good (V), and 1 once it is.
        ("least_voltage", np.float64),
        ("is_off", np.int64),
        # Speed below which the first step's currents are taken for offsets (rad/s), 1 after that step, and these (A).
        ("calibrates_below", np.float64),
        ("is_calibrated", np.int64),
        ("offsets", np.float64, (3,)),
        # 1 if the third current is computed from the other two, as with two sensors; 1 if the currents are those of the
        # preceding step.
        ("computes_third", np.int64),
        ("is_late", np.int64),
        ("before", np.float64, (3,)),
        # Plausibility of single samples: largest current that may vanish in one period (A), the largest one of the
        # preceding step, how often it has vanished, and how often it may.
        ("vanishing_current", np.float64),
        ("current_before", np.float64),
        ("vanishings", np.int64),
        ("vanishings_borne", np.int64),
        # Swing of the speed about its mean that counts as a loose sensor, relative to it (1); the mean (rad/s), the
        # side of it that the speed was on last, and the number of changes of that side.
        ("loose_swing", np.float64),
        ("mean_speed", np.float64),
        ("swing_side", np.float64),
        ("swings", np.int64),
        # Acceleration that counts as a broken coupling, relative to the greatest one toward a reference (1; 0 for
        # none), and what has been seen of the shaft.
        ("breaking_away", np.float64),
        ("shaft", WATCHED_SHAFT),
        # Angle by which the shaft may jump in a period (rad), 0 for any; 1 if a farther jump turns the bridge off, and
        # the sector that it counts as (rad); 1 once a step has been seen, the rotation in the preceding period (rad),
        # and the angle of the preceding step (rad).
        ("farthest_jump", np.float64),
        ("trips_at_jump", np.int64),
        ("jump_taken_for", np.float64),
        ("is_following", np.int64),
        ("turned_before", np.float64),
        ("angle_seen", np.float64),
        # Angle by which what is left of a jump is followed in a period (rad), 0 for jumps that are followed at once.
        ("angle_slew", np.float64),
        # Torque that a speed above its mean takes from the reference (N m s).
        ("damping", np.float64),
        # 1 if the angle at the first step of a shaft at rest is taken for zero.
        ("assumes_zero", np.int64),
        # Step of the link voltage (V), and lost current (A), in whose period a change of the reference is missed, 0 for
        # none; the reference of the preceding step and the one in use (rad/s or N m), and the link voltage of the
        # preceding step (V).
        ("link_step", np.float64),
        ("awaited_current", np.float64),
        ("reference_seen", np.float64),
        ("reference_taken", np.float64),
        ("link_before", np.float64),
        # Fall of the link voltage (V; 0 for none) and rise of the current (A) that together count as a short circuit;
        # the largest current at the fall (A), and the control periods in which it is compared.
        ("link_fall", np.float64),
        ("current_rise", np.float64),
        ("current_at_fall", np.float64),
        ("fallen", np.int64),
        # Factor on the duty ratios about their middle (1), 1 if they are then limited to their range, 1 if two phases
        # are swapped, and the requested control period (s), 0 for none.
        ("stretch", np.float64),
        ("clamps", np.int64),
        ("swaps_phases", np.int64),
        ("next_period", np.float64),
        # Factor on the estimate of the torque (1).
        ("estimate_factor", np.float64),
    ],
    align=True,
)
"""State of a perturbed controller. It must not be moved in memory, and its targets must outlive it."""


def perturbed_state(step_address: int, state_address: int, changes: dict[str, float]) -> NDArray[Any]:
    """Return the state of a perturbed controller, shape (1,) of PERTURBED_STATE.

    The addresses are those of the controller's step and of its state. `changes` contains the fields of PERTURBED_STATE
    that differ from an unperturbed controller.
    """
    state = np.zeros(1, PERTURBED_STATE)
    offsets: Any = PERTURBED_STATE.fields
    state["step_address"], state["state_address"] = step_address, state_address
    for record in ("sense", "command", "currents"):
        state[f"{record}_address"] = state.ctypes.data + offsets[record][1]
    state["command"] = duty_command_record()
    for name in (
        "current_factor",
        "speed_factor",
        "supply_factor",
        "braking_supply_factor",
        "angle_factor",
        "stretch",
        "estimate_factor",
    ):
        state[name] = 1.0
    for name in (
        "backward_limit",
        "braking_voltage",
        "highest_voltage",
        "most_reference",
        "most_speed",
        "braking_until",
        "trips_from",
    ):
        state[name] = np.inf
    for name, value in changes.items():
        state[name] = value
    return state


@inlined
def _wrap_count(state: Any, angle: float) -> None:
    """Wrap a counter at its end: the angle permanently lacks the lost counts."""
    # Without the whole turn by which the angle itself wraps.
    state.turned += within_half_turn(angle - state.angle_before)
    state.angle_before = angle
    if abs(state.turned) >= state.wraps_after:
        lost = state.wraps_after if state.turned > 0.0 else -state.wraps_after
        state.turned -= lost
        state.angle_added -= lost


@inlined
def _count_edge(state: Any, hall: int) -> None:
    """Count any change of the state as one sector: the angle permanently lacks the other sectors."""
    if state.hall_before > 0 and hall != state.hall_before:
        passed = (_SECTORS[hall] - _SECTORS[state.hall_before]) % 6
        state.angle_added -= (passed - 1) * _TURN / 6.0 / state.pole_pairs
    state.hall_before = hall


@inlined
def _stretched(state: Any, ratio: float) -> float:
    """Return the perturbed value of a duty ratio."""
    stretched = float(0.5 + state.stretch * (ratio - 0.5))
    return min(max(stretched, 0.0), 1.0) if state.clamps == 1 else stretched


@inlined
def _ramp_share(state: Any, time: float) -> float:
    """Return the share of a reference that a clock of signed microseconds in 32 bits leaves (1)."""
    shown = time - _SIGNED * floor(time / _SIGNED + 0.5)
    return float(min(max(shown / state.ramp, 0.0), 1.0))


@inlined
def _perturbed_reference(state: Any, sense: Any, taken: float) -> float:
    """Return the reference that the controller sees, of the one that is taken (both rad/s or N m)."""
    if state.ramp > 0.0:
        return float(_ramp_share(state, sense.time) * taken)
    reference = min(max(taken, -state.most_reference), state.most_reference)
    if reference > 0.0:
        return float(max(reference, state.least_reference))
    limit = 0.0 if sense.supply_voltage > state.braking_voltage else state.backward_limit
    return float(max(reference, -limit))


@inlined
def _unseen_direct(state: Any, speed: float) -> float:
    """Return the d-axis current that is hidden from the controller (A), at the shaft's speed (rad/s)."""
    fast = abs(speed)
    if fast > state.weakens_from > 0.0:
        state.is_weakened = 1
    elif fast < state.weakens_until:
        state.is_weakened = 0
    kept = state.is_weakened == 1 and fast < state.weakens_from
    return float(state.direct_added + (state.weakened_by if kept else 0.0))


@inlined
def _calibrate_idle(state: Any) -> None:
    """Have the currents of the next step taken for offsets some time after the torque has vanished."""
    torque = abs(state.command.torque)
    if torque > _LOADED * state.idle_torque:
        state.was_loaded = 1
    is_idle = torque < _IDLE * state.idle_torque
    if state.idling >= state.idle_noticed or (state.was_loaded == 1 and is_idle):
        state.idling += 1
    else:
        state.idling = 0
    if state.idling >= state.idle_calibrated:
        state.is_calibrated = 0
        state.idling = 0
        state.was_loaded = 0


@inlined
def _perturb_beyond(state: Any, sense: Any, perturbed: Any) -> None:
    """Refuse to brake, or turn the bridge off, beyond a speed."""
    if perturbed.reference * sense.speed < 0.0 and abs(sense.speed) > state.braking_until:
        perturbed.reference = 0.0
    if abs(sense.speed) > state.trips_from:
        state.is_off = 1


@inlined
def _write_sense(state: Any, sense: Any) -> None:
    """Write the perturbed Sense for the controller."""
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    hidden = _unseen_direct(state, sense.speed) + burst_current(state, sense)
    added = RotorFrame(hidden, 0.0, cosine, sine)
    if state.idle_torque > 0.0:
        _calibrate_idle(state)
    for phase in range(3):
        measured = state.current_factor * double_at(sense.phase_currents, phase) + phase_current(added, phase)
        if phase == 0:
            measured += state.current_added
        if state.is_calibrated == 0 and abs(sense.speed) < state.calibrates_below:
            state.offsets[phase] = measured
        measured -= state.offsets[phase]
        state.currents[phase] = state.before[phase] if state.is_late == 1 else measured
        state.before[phase] = measured
    state.is_calibrated = 1
    if state.computes_third == 1:
        state.currents[2] = -state.currents[0] - state.currents[1]
    taken = taken_reference(state, sense)
    follow_shaft(state, sense)
    state.sense = sense
    perturbed = state.sense
    perturbed.phase_currents = state.currents_address
    perturbed.supply_voltage = state.supply_factor * sense.supply_voltage
    if sense.reference * sense.speed < 0.0:
        perturbed.supply_voltage *= state.braking_supply_factor
        if sense.supply_voltage > state.highest_voltage:
            state.is_off = 1
    if state.wraps_after > 0.0:
        _wrap_count(state, sense.angle)
    if state.counts_edges == 1 and sense.hall > 0:
        _count_edge(state, sense.hall)
    perturbed.angle = state.angle_factor * sense.angle + state.angle_added
    perturbed.angle += state.ahead * (abs(sense.speed) - sense.speed)
    perturbed.speed = state.speed_factor * sense.speed if abs(sense.speed) >= state.least_speed else 0.0
    perturbed.speed = min(max(perturbed.speed, -state.most_speed), state.most_speed)
    perturbed.reference = _perturbed_reference(state, sense, taken)
    perturbed.reference -= state.damping * max(sense.speed - state.mean_speed, 0.0)
    _perturb_beyond(state, sense, perturbed)
    perturb_free_shaft(state, sense, perturbed)
    perturb_heat(state, sense, perturbed)
    if mistakes_samples(state, sense) or is_short_circuit(state, sense):
        state.is_off = 1


@inlined
def _write_command(state: Any, command: Any) -> None:
    """Write the perturbed command."""
    controller_command = state.command
    command.first_duty = _stretched(state, controller_command.first_duty)
    command.second_duty = _stretched(state, controller_command.second_duty)
    command.third_duty = _stretched(state, controller_command.third_duty)
    if state.swaps_phases == 1:
        second = command.second_duty
        command.second_duty = command.third_duty
        command.third_duty = second
    command.first_leg = controller_command.first_leg
    command.second_leg = controller_command.second_leg
    command.third_leg = controller_command.third_leg
    command.next_period = state.next_period
    command.torque = state.estimate_factor * controller_command.torque
    command.angle = controller_command.angle
    command.speed = controller_command.speed
    command.input_power = controller_command.input_power
    command.fault = controller_command.fault
    if state.sense.supply_voltage < state.least_voltage:
        state.is_off = 1
    lowers = state.sense.speed < 0.0 < controller_command.torque
    if state.is_off == 1 or (state.refuses_lowering == 1 and lowers):
        command.first_leg = LEG_OFF
        command.second_leg = LEG_OFF
        command.third_leg = LEG_OFF


@inlined
def step_perturbed(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period with perturbed Sense and command."""
    _write_sense(state, sense)
    call_step(state.step_address, state.state_address, state.sense_address, state.command_address)
    _write_command(state, command)


@cache
def perturbed_step_function() -> Any:
    """Return the step of a perturbed controller, compiled.

    Its `address` is that of a C function whose state is a PERTURBED_STATE. The caller must retain the object.
    """
    signature = step_signature(PERTURBED_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_perturbed(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)
