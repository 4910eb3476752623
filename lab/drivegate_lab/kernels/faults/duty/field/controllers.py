"""Field-oriented control with one fault from the field, before or after its step."""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
from numba.np.numpy_support import carray

from drivegate_lab.kernels.faults.duty.field import state as faults
from drivegate_lab.kernels.faults.duty.field.clocks import alter_by_clock
from drivegate_lab.kernels.faults.duty.field.measurements import (
    alter_by_lost_samples,
    alter_over_minutes,
    filter_link,
    trip_at_sag,
    write_currents,
)
from drivegate_lab.kernels.faults.duty.field.references import (
    alter_after_fall,
    alter_after_stop,
    alter_regulator,
    alter_size,
    limit_torque,
    wind_up,
)
from drivegate_lab.kernels.faults.duty.field.state import FIELD_STATE
from drivegate_models.compilation.calling import call_step, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import LEG_OFF


@inlined
def _alter(state: Any, sense: Any, fault: int) -> None:
    """Change the controller's copy of the Sense, and its state, before a step."""
    if fault in (faults.FALL_MISSED, faults.WEAKENING_KEPT_AFTER_FALL):
        alter_after_fall(state, fault)
    elif fault in (faults.WEAKENING_KEPT_THROUGH_STOP, faults.TORQUE_CUT_AFTER_STOP):
        alter_after_stop(state, fault)
    elif fault in (faults.LOST_SAMPLES_COUNTED, faults.LOST_SAMPLES_AVERAGED):
        alter_by_lost_samples(state, sense, fault)
    elif fault == faults.LINK_SAG_TRIPS:
        trip_at_sag(state)
    elif fault == faults.LINK_FILTERED:
        filter_link(state)
    elif fault in (faults.DRIVING_LIMITED, faults.LOWERING_LIMITED):
        limit_torque(state, fault)
    alter_by_clock(state, fault)
    alter_size(state, fault)
    alter_regulator(state, fault)
    alter_over_minutes(state, fault)


@inlined
def step_field_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period, with the state's fault."""
    state.steps += 1
    state.sense = sense
    state.direct_hidden = 0.0
    fault = state.fault if state.acts == 1 else 0
    _alter(state, sense, fault)
    write_currents(state, sense)
    state.time_before = sense.time
    integral = state.controller.speed_integral
    call_step(state.step_address, state.controller_address, state.sense_address, state.command_address)
    if fault == faults.WINDS_UP:
        wind_up(state, integral)
    command.first_duty = state.command.first_duty
    command.second_duty = state.command.second_duty
    command.third_duty = state.command.third_duty
    command.first_leg = LEG_OFF if state.is_off == 1 else state.command.first_leg
    command.second_leg = LEG_OFF if state.is_off == 1 else state.command.second_leg
    command.third_leg = LEG_OFF if state.is_off == 1 else state.command.third_leg
    command.next_period = state.command.next_period
    command.torque = state.command.torque
    command.angle = state.command.angle
    command.speed = state.command.speed
    command.input_power = state.command.input_power
    command.fault = state.command.fault


@cache
def field_step_function() -> Any:
    """Return the step of a controller with a field fault, compiled.

    Its `address` is that of a C function whose state is a FIELD_STATE. The caller must retain the object.
    """
    signature = step_signature(FIELD_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_field_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)
