"""The faulty controllers with the native interface: a built-in step with one fault before or after it.

The built-in controllers are not changed. Faults that are only other constants need no code here.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
from numba.np.numpy_support import carray

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_lab.kernels.faults.current.clocks import (
    alter_search_by_counters,
    alter_search_by_rounding,
    alter_sense_by_rounding,
    round_angle,
    search_has_ended,
)
from drivegate_lab.kernels.faults.current.commands import (
    alter_angle,
    alter_angle_by_history,
    alter_estimate,
    alter_reference,
    delay_command,
    undo_search,
    waste_time,
)
from drivegate_lab.kernels.faults.current.filters import filter_command, filter_sense
from drivegate_lab.kernels.faults.current.regions import alter_in_region, cap_speed_reference
from drivegate_lab.kernels.faults.current.searches import (
    alter_search_after,
    alter_search_before,
    alter_sense,
    alter_sense_by_history,
)
from drivegate_lab.kernels.faults.current.state import FAULTY_STATE
from drivegate_lab.kernels.faults.current.tolerances import alter_speed, cycle_angle
from drivegate_lab.kernels.faults.current.trips import derate, end_advance
from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.controllers.current.builtin import step_state


@inlined
def faulty_step_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period, with the state's fault."""
    fault = state.fault
    state.steps += 1
    # A copy: the fault alters the Sense of its controller, not the caller's record.
    state.sense = sense
    state.true_sum = sense.current_magnitude_sum
    alter_sense(fault, state.size, state.sense)
    alter_sense_by_history(state, fault)
    alter_sense_by_rounding(state, fault)
    filter_sense(state, fault)
    cap_speed_reference(state, fault)
    alter_speed(state, fault)
    alter_search_before(state, fault)
    alter_search_by_counters(state, fault)
    # Some faults undo the search of a step, and need the state before it.
    state.before = state.controller
    step_state(state.controller, state.sense, command)
    alter_search_after(state, fault)
    alter_search_by_rounding(state, fault)
    if search_has_ended(state, fault):
        undo_search(state, command)
    alter_reference(state, fault, command)
    alter_angle(state, fault, command)
    alter_angle_by_history(state, fault, command)
    alter_estimate(state, fault, command)
    filter_command(state, fault, command)
    derate(state, fault, command)
    end_advance(state, fault, command)
    alter_in_region(state, fault, command)
    cycle_angle(state, fault, command)
    round_angle(state, fault, command)
    if fault == faults.DELAYED:
        delay_command(state, command)
    if fault == faults.SLOW:
        waste_time(state)


@cache
def faulty_step_function() -> Any:
    """Return the faulty controllers' `drivegate_step`, compiled.

    Its `address` is that of a C function. The caller must retain the object.
    """
    signature = step_signature(FAULTY_STATE, SENSE, COMMAND)

    def drivegate_faulty_step(state: Any, sense: Any, command: Any) -> None:
        faulty_step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_faulty_step)
