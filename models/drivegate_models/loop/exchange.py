"""The records between a closed loop and its controller, and one step of a controller of a current contract."""

from __future__ import annotations

from math import inf, isfinite, nan
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.layout import Layout
from drivegate_models.loop.loop_inputs import SteppedController

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
    """Input of the controller, shape (1,) of the contract's sense."""
    command: NDArray[Any]
    """Output of the controller, shape (1,) of the contract's command."""
    command_bits: NDArray[np.int64]
    """A view of the command as 64-bit words, shape (n,)."""
    fresh: NDArray[Any]
    """A command before the controller writes it, shape (1,)."""
    sensed_currents: NDArray[np.float64]
    """Phase currents of the Sense, shape (m,) (A)."""
    progress: NDArray[np.int64]
    """Number of steps begun, shape (1,), monitored by the parent process."""
    kept: NDArray[Any]
    """Receives the command of each step, shape (n,) of the contract's command."""
    step_address: int
    state_address: int
    sense_address: int
    command_address: int


def make_exchange(layout: Layout, phases: int, controller: SteppedController) -> Exchange:
    """Return the records between the loop and a controller, for a number of phases."""
    currents = np.zeros(phases)
    sense, command = layout.fresh_sense(currents), layout.fresh_command()
    return Exchange(
        sense=sense,
        command=command,
        command_bits=command.view(np.int64),
        fresh=layout.fresh_command(),
        sensed_currents=currents,
        progress=np.zeros(1, np.int64) if controller.progress is None else controller.progress,
        kept=np.zeros(0, layout.command) if controller.kept is None else controller.kept,
        step_address=controller.step_address,
        state_address=controller.state_address,
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
