"""Correct controllers of other designs than the reference, with the native interface.

All share the reference's regulator, angle model and protections. They differ in the choice of the next angle. The
harness tests itself with them: it must not accuse any of them.
"""

from __future__ import annotations

from functools import cache
from types import MappingProxyType
from typing import Any, Final

import numba
from numba.np.numpy_support import carray

from drivegate_lab.kernels.designs.search import decide_design
from drivegate_lab.kernels.designs.state import (
    ANGLE_TABLE,
    DESIGN_STATE,
    GOLDEN_SECTION,
    QUADRATIC_INTERPOLATION,
    SWEEP,
)
from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.controllers.current.builtin import (
    begin_interval,
    current_reference,
    line_angle,
    observe,
    reset_state,
    write_command,
)
from drivegate_models.controllers.current.state import GUARDED

DESIGNS: Final = MappingProxyType(
    {
        "golden-section": GOLDEN_SECTION,
        "quadratic-interpolation": QUADRATIC_INTERPOLATION,
        "angle-table": ANGLE_TABLE,
        "sweep": SWEEP,
    }
)
"""Number of each design."""


@inlined
def reset_design(state: Any, nameplate: Any, design: int) -> None:
    """Write the constants of a design (one of `DESIGNS`) and reset everything else."""
    # The start of a search writes the rest.
    reset_state(state.controller, nameplate, GUARDED)
    state.controller.tries_again = 0
    state.controller.angle_proportional = 0.0
    state.design = design
    state.tabled = 0
    state.target = 0.0
    state.waited = 0
    state.decisions = 0
    state.finished = 0
    state.confirming = 0


@inlined
def step_design(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period."""
    controller = state.controller
    reference = current_reference(controller, sense)
    if controller.advancing == 1 and observe(controller, sense, reference):
        state.speed = max(sense.speed, controller.base_speed)
        state.line = line_angle(controller, state.speed)
        decide_design(state)
        begin_interval(controller)
    write_command(controller, sense, reference, command)


@cache
def design_step_function() -> Any:
    """Return the designs' `drivegate_step`, compiled.

    Its `address` is that of a C function. The caller must retain the object.
    """
    signature = step_signature(DESIGN_STATE, SENSE, COMMAND)

    def drivegate_step(state: Any, sense: Any, command: Any) -> None:
        step_design(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_step)


@cache
def design_reset_function() -> Any:
    """Return the compiled function that resets a design.

    Its arguments are the state, shape (1,) of DESIGN_STATE, the nameplate, shape (1,) of NAMEPLATE, and the design.
    """

    def reset(state: Any, nameplate: Any, design: int) -> None:
        reset_design(state[0], nameplate[0], design)

    return numba.njit(cache=KEEPS_CACHE)(reset)
