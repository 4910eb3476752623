"""A built-in controller of which some blocks of Fig. 2 are replaced by functions that are called by address.

What is not replaced is the built-in controllers' own code, and so is the state.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np

from drivegate_models.compilation.calling import call_step, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.controllers.current.builtin import answer, current_reference, line_speed, search
from drivegate_models.controllers.current.state import CONTROLLER_STATE, NO_SEARCH

COMPOSED_STATE: Final = np.dtype(
    [
        ("controller", CONTROLLER_STATE),
        # Addresses of the blocks that are replaced, 0 for those that are not.
        ("angle_model", np.int64),
        ("speed_regulator", np.int64),
        ("search", np.int64),
        # What a block is given besides the Sense.
        ("line_speed", np.float64),
        ("current_reference", np.float64),
        ("integral", np.float64),
    ],
    align=True,
)
"""State of a composed controller; `integral` is what a regulator keeps and the guarded search may set back (A).

A block is called like a step and answers in a field of the command: the angle model and the search in
`advance_angle` (rad), the regulator in `current_reference` (A).
"""


@cache
def composed_step_function() -> Any:
    """Return the composed controllers' `drivegate_step`, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a C function whose state is a COMPOSED_STATE; keep the object.
    """
    # numba has to be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    signature = step_signature(COMPOSED_STATE, SENSE, COMMAND)

    def drivegate_step(composed_pointer: Any, sense_pointer: Any, command_pointer: Any) -> None:
        senses, commands = carray(sense_pointer, 1), carray(command_pointer, 1)
        composed, sense, command = carray(composed_pointer, 1)[0], senses[0], commands[0]
        sense_address, command_address = senses.ctypes.data, commands.ctypes.data
        state = composed.controller
        if composed.speed_regulator != 0:
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
        answer(state, sense, reference, command)

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_step)
