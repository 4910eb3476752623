"""Faults of what a controller measures: lost samples, the link, and what adds up over minutes."""

from __future__ import annotations

from typing import Any

import numpy as np

from drivegate_lab.kernels.faults.duty.field import state as faults
from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.cycle import within_half_turn
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine


@inlined
def write_currents(state: Any, sense: Any) -> None:
    """Write the currents that the controller sees, with a hidden d current and an offset of the first sensor."""
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    hidden = RotorFrame(state.direct_hidden, 0.0, cosine, sine)
    for phase in range(3):
        state.currents[phase] = double_at(sense.phase_currents, phase) + phase_current(hidden, phase)
    state.currents[0] += state.offset
    state.sense.phase_currents = state.currents_address


@inlined
def alter_by_lost_samples(state: Any, sense: Any, fault: int) -> None:
    """Count samples without currents, without a speed or without a link, each once."""
    currents = sense.phase_currents
    empty = double_at(currents, 0) == 0.0 and double_at(currents, 1) == 0.0 and double_at(currents, 2) == 0.0
    # The first steps have no currents yet.
    is_lost = (empty and state.steps > 100) or sense.supply_voltage == 0.0
    if is_lost and state.stage == 0:
        state.count += 1
        if fault == faults.LOST_SAMPLES_AVERAGED:
            state.offset += state.size
    state.stage = 1 if is_lost else 0
    if fault == faults.LOST_SAMPLES_COUNTED and state.count >= state.size:
        state.is_off = 1


@inlined
def trip_at_sag(state: Any) -> None:
    """Turn the bridge off where the link sags while the drive brakes at high speed."""
    sense = state.sense
    brakes = sense.reference * sense.speed < 0.0 and abs(sense.speed) > state.size
    # A link that reads 0 is a lost sample.
    if brakes and 0.0 < sense.supply_voltage < state.extent:
        state.is_off = 1


@inlined
def filter_link(state: Any) -> None:
    """Show the controller the link's voltage through a filter of first order, which leaves a lost sample out."""
    sense = state.sense
    if state.steps == 1:
        state.memory = sense.supply_voltage
    elif sense.supply_voltage > 0.0:
        state.memory += state.control_period / state.size * (sense.supply_voltage - state.memory)
    sense.supply_voltage = state.memory


@inlined
def alter_over_minutes(state: Any, fault: int) -> None:
    """Change what adds up over a long time: an offset, a model of the heat, and a sum of all turns."""
    sense, controller = state.sense, state.controller
    if fault == faults.OFFSET_CREEPS:
        state.offset += state.size * state.control_period
    elif fault == faults.HEATS_UP:
        # Over that of rated torque, of which the fault leaves half.
        heat = (0.5 * controller.seen_torque / state.extent) ** 2
        state.memory += state.control_period / state.size * (heat - state.memory)
        if state.memory > 0.5:
            controller.greatest_torque = state.extent
    elif fault == faults.TURNS_SUMMED:
        if state.steps == 1:
            state.turned = np.float32(sense.angle)
        else:
            turn = within_half_turn(sense.angle - state.angle_before)
            state.turned = np.float32(state.turned + np.float32(turn))
        state.angle_before = sense.angle
        sense.angle = float(state.turned)
