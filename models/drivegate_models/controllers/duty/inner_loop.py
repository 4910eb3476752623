"""An inner current loop that runs a controller of current reference and advance angle on duty ratios.

The reference I and the advance angle b become ``i_d = -I sin b`` and ``i_q = I cos b``. The outer step is called by
address every few control periods, with a Sense of its own contract.
"""

from __future__ import annotations

from functools import cache
from math import isfinite, nan, pi
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step, double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.controllers.duty.current_regulator import (
    regulate_currents,
    reset_regulator,
    rotor_currents,
)
from drivegate_models.controllers.duty.state import FOC_STATE
from drivegate_models.machine.sine import cosine_sine

_SENSE_SIZE: Final = SENSE.itemsize
_COMMAND_SIZE: Final = COMMAND.itemsize

INNER_STATE: Final = np.dtype(
    [
        ("regulator", FOC_STATE),
        # The outer controller: addresses of its step, of its state and of the records below.
        ("step_address", np.int64),
        ("state_address", np.int64),
        ("sense_address", np.int64),
        ("command_address", np.int64),
        ("sense", SENSE),
        ("command", COMMAND),
        # Control periods per step of the outer controller, how many have passed, and the current sum over them (A).
        ("periods", np.int64),
        ("count", np.int64),
        ("magnitude_sum", np.float64),
        ("direct_reference", np.float64),
        ("quadrature_reference", np.float64),
    ],
    align=True,
)
"""State of the inner loop. It must not be moved in memory, and the records at its addresses must outlive it."""


def inner_state(step_address: int, state_address: int, periods: int) -> NDArray[Any]:
    """Return the state of an inner loop, shape (1,) of INNER_STATE, before its reset.

    The addresses are those of the outer controller's step and of its state, which must be reset for steps of
    `periods` control periods of the inner loop.
    """
    state = np.zeros(1, INNER_STATE)
    offsets: Any = INNER_STATE.fields
    state["step_address"] = step_address
    state["state_address"] = state_address
    state["sense_address"] = state.ctypes.data + offsets["sense"][1]
    state["command_address"] = state.ctypes.data + offsets["command"][1]
    state["periods"] = periods
    return state


@inlined
def _call_outer_step(inner: Any, sense: Any) -> bool:
    """Call the outer controller for currents; return True if its command contains finite numbers."""
    outer = inner.sense
    outer.struct_size = _SENSE_SIZE
    outer.time = sense.time
    outer.speed_reference = sense.reference
    outer.speed = sense.speed
    outer.phase_count = 3
    outer.phase_currents = sense.phase_currents
    outer.current_magnitude_sum = inner.magnitude_sum / inner.periods
    outer.half_supply_voltage = 0.5 * sense.supply_voltage
    outer_command = inner.command
    outer_command.struct_size = _COMMAND_SIZE
    outer_command.current_reference = nan
    outer_command.advance_angle = nan
    outer_command.input_power = nan
    call_step(inner.step_address, inner.state_address, inner.sense_address, inner.command_address)
    inner.magnitude_sum = 0.0
    if not (isfinite(outer_command.current_reference) and isfinite(outer_command.advance_angle)):
        return False
    current = min(max(outer_command.current_reference, 0.0), inner.regulator.current_limit)
    cosine, sine = cosine_sine(min(max(outer_command.advance_angle, 0.0), 0.5 * pi))
    inner.direct_reference = -current * sine
    inner.quadrature_reference = current * cosine
    return True


@inlined
def step_inner(inner: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period.

    The command has no duty ratios if the outer controller returns no numbers, and stops the run if the outer one
    stops it.
    """
    for phase in range(3):
        inner.magnitude_sum += abs(double_at(sense.phase_currents, phase))
    if inner.count == 0:
        has_command = _call_outer_step(inner, sense)
        if inner.command.struct_size < 0:
            command.struct_size = inner.command.struct_size
            return
        if not has_command:
            # The duty ratios are still missing, as before the step.
            return
    inner.count = (inner.count + 1) % inner.periods
    regulator = inner.regulator
    direct, quadrature = rotor_currents(regulator, sense)
    regulate_currents(
        regulator,
        sense,
        command,
        direct,
        quadrature,
        inner.direct_reference,
        inner.quadrature_reference,
    )
    command.angle = sense.angle
    command.speed = sense.speed
    command.input_power = inner.command.input_power


@cache
def inner_step_function() -> Any:
    """Return the inner loop's step, compiled.

    Its `address` is that of a C function whose state is an INNER_STATE. The caller must retain the object.
    """
    signature = step_signature(INNER_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(inner: Any, sense: Any, command: Any) -> None:
        step_inner(carray(inner, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)


@cache
def inner_reset_function() -> Any:
    """Return the compiled function that resets the inner loop, without the outer controller.

    Its arguments are the state, shape (1,) of INNER_STATE, and the nameplate, shape (1,) of DUTY_NAMEPLATE.
    """

    def reset(inner: Any, nameplate: Any) -> None:
        reset_regulator(inner[0].regulator, nameplate[0])
        inner[0].count = 0
        inner[0].magnitude_sum = 0.0
        inner[0].direct_reference = 0.0
        inner[0].quadrature_reference = 0.0

    return numba.njit(cache=KEEPS_CACHE)(reset)
