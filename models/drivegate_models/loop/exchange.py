"""One step of a controller: the only place where the compiled loop of a current contract calls it."""

from __future__ import annotations

from math import inf, isfinite, nan
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.current.records import COMMAND, SENSE

OUTPUTS: Final = ("current_reference", "advance_angle", "input_power")
"""The numbers of a Command, in the order of the columns wherever commands are rows."""
COMPLETED: Final = 0
"""Status of a step: the controller returned a command. Status of a run: it reached its end."""
STOPPED: Final = 1
"""Status: the controller's bridge requested a stop, and stores the reason."""
NOT_FINITE: Final = 2
"""Status: the controller's command was not finite; the last Sense contains its input."""

_WORD = 0xFFFFFFFF
_FNV_PRIME = 16777619


class Exchange(NamedTuple):
    """The records between loop and controller, and the controller's addresses."""

    sense: NDArray[Any]
    """Input of the controller, shape (1,) of contract.SENSE."""
    command: NDArray[Any]
    """Output of the controller, shape (1,) of contract.COMMAND."""
    command_bits: NDArray[np.int64]
    """A view of the command as 64-bit words, shape (4,)."""
    sensed_currents: NDArray[np.float64]
    """Phase currents of the Sense, shape (m,) (A)."""
    progress: NDArray[np.int64]
    """Number of steps begun, shape (1,), monitored by the parent process."""
    kept: NDArray[Any]
    """Receives the command of each step, shape (n,) of contract.COMMAND; commands after its end are not stored."""
    step_address: int
    state_address: int
    sense_address: int
    command_address: int


def make_exchange(
    phases: int,
    *,
    step_address: int,
    state_address: int,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
) -> Exchange:
    """Return the records between the loop and a controller that has been reset.

    `phases`: number of phases m. `step_address`, `state_address`: addresses of the controller's step function and of
    its state. `progress`, shape (1,): receives the number of steps begun. `kept`, shape (n,): receives the commands of
    the first n steps.
    """
    sense = np.zeros(1, SENSE)
    currents = np.zeros(phases)
    command = np.zeros(1, COMMAND)
    sense[0]["struct_size"] = SENSE.itemsize
    sense[0]["phase_count"] = phases
    sense[0]["phase_currents"] = currents.ctypes.data
    command[0]["struct_size"] = COMMAND.itemsize
    return Exchange(
        sense=sense,
        command=command,
        command_bits=command.view(np.int64),
        sensed_currents=currents,
        progress=np.zeros(1, np.int64) if progress is None else progress,
        kept=np.zeros(0, COMMAND) if kept is None else kept,
        step_address=step_address,
        state_address=state_address,
        sense_address=sense.ctypes.data,
        command_address=command.ctypes.data,
    )


@inlined
def command_status(command: Any) -> int:
    """Return whether a command lets a run go on; a value outside its range is for a check to judge.

    Result: `COMPLETED`, `STOPPED` or `NOT_FINITE`.
    """
    if command.struct_size < 0:
        return STOPPED
    finite = isfinite(command.current_reference) and isfinite(command.advance_angle)
    # A power of NaN means that the controller estimates none.
    if not finite or abs(command.input_power) == inf:
        return NOT_FINITE
    return COMPLETED


@inlined
def step_controller(exchange: Exchange, step: int) -> int:
    """Call the controller's step on the present Sense, and check its command.

    `step`: number of the step, from 0. Result: `COMPLETED`, `STOPPED` or `NOT_FINITE`.
    """
    command = exchange.command
    # A missing output must not repeat the output of the preceding step.
    command[0].current_reference = nan
    command[0].advance_angle = nan
    command[0].input_power = nan
    # Count before the call, so that a monitor knows in which step a controller hangs.
    exchange.progress[0] = step + 1
    call_step(exchange.step_address, exchange.state_address, exchange.sense_address, exchange.command_address)
    status = command_status(command[0])
    if status != STOPPED and step < exchange.kept.size:
        kept = exchange.kept[step]
        kept.current_reference = command[0].current_reference
        kept.advance_angle = command[0].advance_angle
        kept.input_power = command[0].input_power
    return status


@inlined
def _digested(digest: int, bits: int) -> int:
    """Add a 64-bit word to a digest: two rounds of FNV-1a over its halves, each mixed downward, in 63 bits."""
    low = digest & _WORD
    high = digest >> 32
    low = ((low ^ (bits & _WORD)) * _FNV_PRIME) & _WORD
    low ^= low >> 15
    high = ((high ^ low ^ ((bits >> 32) & _WORD)) * _FNV_PRIME) & _WORD
    high = (high ^ (high >> 15)) & 0x7FFFFFFF
    return (high << 32) | low


@inlined
def digested_command(digest: int, exchange: Exchange) -> int:
    """Add the numbers of a command, bit for bit, to a digest.

    `digest`: digest of the previous commands. `exchange`: its `command_bits` are read. Result: digest of all commands,
    in 63 bits.
    """
    for word in range(1, 4):
        digest = _digested(digest, exchange.command_bits[word])
    return digest
