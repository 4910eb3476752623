"""Steps of a controller of duty ratios on prescribed Senses: there is no plant and no feedback."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import unallocating
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE, duty_command_record
from drivegate_models.loop.duty_command import duty_command_status
from drivegate_models.loop.exchange import COMPLETED


class GivenDutySteps(NamedTuple):
    """A controller, its prescribed Senses, and the records of its steps."""

    step_address: int
    """Address of the controller's step."""
    state_address: int
    """Address of its state."""
    senses: NDArray[Any]
    """Input of each step, shape (n,) of DUTY_SENSE."""
    currents: NDArray[np.float64]
    """Phase currents to which the Senses point, shape (n, 3) (A)."""
    command: NDArray[Any]
    """Output of the present step, shape (1,) of DUTY_COMMAND."""
    fresh: NDArray[Any]
    """Initial value of the command in each step, shape (1,) of DUTY_COMMAND."""
    progress: NDArray[np.int64]
    """Number of steps begun, shape (1,), monitored by another process."""
    kept: NDArray[Any]
    """Receives the commands, shape (m,) of DUTY_COMMAND; commands after its end are not stored."""


@unallocating
def make_duty_steps(given: GivenDutySteps) -> tuple[int, int]:
    """Step a controller, already reset, through prescribed Senses.

    Parameters
    ----------
    given : GivenDutySteps
        Its `progress`, `command` and `kept` are updated.

    Returns
    -------
    status : int
        `COMPLETED`, or the status of `duty_command.duty_command_status` at which the steps ended.
    answered : int
        Number of completed steps, and so the number of the step with another status.
    """
    senses, command, kept = given.senses, given.command, given.kept
    for k in range(senses.size):
        command[0] = given.fresh[0]
        # Count before the call, so that a monitor knows in which step a controller hangs.
        given.progress[0] = k + 1
        call_step(
            given.step_address,
            given.state_address,
            senses.ctypes.data + k * senses.itemsize,
            command.ctypes.data,
        )
        if k < kept.size:
            kept[k] = command[0]
        status = duty_command_status(command[0])
        if status != COMPLETED:
            return status, k
    return COMPLETED, senses.size


def given_duty_steps(
    step_address: int,
    state_address: int,
    senses: NDArray[Any],
    currents: NDArray[np.float64],
    *,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
) -> GivenDutySteps:
    """Return the records for the steps of a controller on prescribed Senses.

    Parameters
    ----------
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    senses : ndarray of DUTY_SENSE, shape (n,)
        Prescribed Senses; their addresses of phase currents need not be set.
    currents : ndarray, shape (n, 3)
        Phase currents of the Senses (A).
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.
    kept : ndarray of DUTY_COMMAND, shape (m,), optional
        Receives the commands of the first m steps.

    Returns
    -------
    GivenDutySteps
        Argument of `make_duty_steps`, with copies of the Senses.
    """
    given, currents = senses.copy(), np.ascontiguousarray(currents, np.float64)
    given["struct_size"] = DUTY_SENSE.itemsize
    given["phase_currents"] = currents.ctypes.data + np.arange(len(given)) * (currents.itemsize * 3)
    return GivenDutySteps(
        step_address,
        state_address,
        given,
        currents,
        duty_command_record(),
        duty_command_record(),
        np.zeros(1, np.int64) if progress is None else progress,
        np.zeros(0, DUTY_COMMAND) if kept is None else kept,
    )
