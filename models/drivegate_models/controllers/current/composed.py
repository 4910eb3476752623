"""A built-in controller in which functions called by address replace some blocks of Fig. 2.

The other blocks, and the state, are those of the built-in controllers.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np

from drivegate_models.compilation.calling import call_step, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.controllers.current.builtin import current_reference, line_speed, search, write_command
from drivegate_models.controllers.current.modes import is_following
from drivegate_models.controllers.current.state import CONTROLLER_STATE, NO_SEARCH

COMPOSED_STATE: Final = np.dtype(
    [
        ("controller", CONTROLLER_STATE),
        # Addresses of the replaced blocks, 0 for all others.
        ("angle_model", np.int64),
        ("speed_regulator", np.int64),
        ("search", np.int64),
        # Inputs of a block in addition to the Sense.
        ("line_speed", np.float64),
        ("current_reference", np.float64),
        ("integral", np.float64),
    ],
    align=True,
)
"""State of a composed controller. `integral` is the regulator's integral (A), which the guarded search may reduce.

A block is called like a step and writes its output to a field of the command. The angle model and the search write
`advance_angle` (rad electrical), the regulator writes `current_reference` (A).
"""


@cache
def composed_step_function() -> Any:
    """Return the composed controllers' `drivegate_step`, compiled.

    Its `address` is that of a C function whose state is a COMPOSED_STATE. The caller must retain the object.
    """
    # numba must be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    signature = step_signature(COMPOSED_STATE, SENSE, COMMAND)

    def drivegate_step(composed_pointer: Any, sense_pointer: Any, command_pointer: Any) -> None:
        senses, commands = carray(sense_pointer, 1), carray(command_pointer, 1)
        composed, sense, command = carray(composed_pointer, 1)[0], senses[0], commands[0]
        sense_address, command_address = senses.ctypes.data, commands.ctypes.data
        state = composed.controller
        # Where the search has let the current go, there is nothing for the block to regulate.
        if composed.speed_regulator != 0 and not is_following(state):
            composed.integral = state.integral
            call_step(composed.speed_regulator, 0, sense_address, command_address)
            if command.struct_size < 0:
                return
            reference = command.current_reference
            state.integral = composed.integral
        else:
            reference = current_reference(state, sense)
        if state.advancing == 1 and composed.search != 0:
            composed.current_reference = reference
            call_step(composed.search, 0, sense_address, command_address)
            if command.struct_size < 0:
                return
            state.offset = command.advance_angle
        elif state.advancing == 1 and state.search != NO_SEARCH:
            search(state, sense, reference)
        if composed.angle_model != 0 and sense.speed >= state.base_speed:
            composed.line_speed = line_speed(state, sense.speed)
            call_step(composed.angle_model, 0, sense_address, command_address)
            if command.struct_size < 0:
                return
            # A line without slope is the angle itself.
            state.angle_at_base = command.advance_angle
            state.angle_slope = 0.0
        write_command(state, sense, reference, command)

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_step)
