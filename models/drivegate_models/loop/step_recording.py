"""Recording every step of a controller as sensed and answered, and playing its commands back, whatever its contract.

A recorder is called in place of a controller: it passes each step on and copies both records into a row. A player
answers with recorded commands, whatever it senses.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numba
import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step, copy_bytes, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import STOP
from drivegate_models.contract.layout import Layout

_WORD: Final = np.dtype(np.int64)
_PLAYER: Final = np.dtype(
    [("commands_address", np.int64), ("size", np.int64), ("count", np.int64), ("given", np.int64)], align=True
)
"""State of the playing step: the address of `count` commands, the size of each (bytes), and how many were given."""
RECORDER: Final = np.dtype(
    [
        ("step_address", np.int64),
        ("state_address", np.int64),
        ("rows_address", np.int64),
        ("capacity", np.int64),
        ("count", np.int64),
        ("sense_size", np.int64),
        ("currents_place", np.int64),
        ("currents_size", np.int64),
        ("command_size", np.int64),
        ("every", np.int64),
        ("skipped", np.int64),
    ],
    align=True,
)
"""A recorder: the controller that it passes steps on to, the room for rows, and how many of them are written.

`currents_place` is the number of the sense's 64-bit field with the address of the phase currents. Sizes are in bytes.
Of `every` steps one is recorded, and `skipped` is the number of steps until then.
"""


def row_layout(layout: Layout, phases: int) -> np.dtype[Any]:
    """Return the layout of a row.

    `phases`: number of phases m. Result: a `sense`, its `currents` (A) and the `command` that answers it.
    """
    return np.dtype(
        [("sense", layout.sense), ("currents", np.float64, (phases,)), ("command", layout.command)]
    )


def recorder_of(
    rows: NDArray[Any], step_address: int, state_address: int, *, every: int = 1, skipped: int = 0
) -> NDArray[Any]:
    """Make the state of a recording step.

    - `rows`, shape (n,): receives the steps; it has to outlive the state.
    - `step_address`, `state_address`: addresses of the controller's step function and of its state.
    - `every`: record every n-th step; n is at least 1.
    - `skipped`: number of steps at the start that are not recorded.
    """
    sense, currents, command = (rows.dtype[name] for name in ("sense", "currents", "command"))
    place = (sense.names or ()).index("phase_currents")
    sizes = (sense.itemsize, place, currents.itemsize, command.itemsize)
    recorder = (step_address, state_address, rows.ctypes.data, len(rows), 0, *sizes, every, skipped)
    return np.array([recorder], RECORDER)


@cache
def recording_step() -> Any:
    """Return the recorder's own step, compiled.

    Result: its `address` is that of a step function of any contract, whose state is a RECORDER. The caller must retain
    it.
    """

    def record_step(recorder: Any, sense: Any, command: Any) -> None:
        kept = carray(recorder, 1)[0]
        sensed, answer = carray(sense, kept.sense_size // 8), carray(command, 1)
        call_step(kept.step_address, kept.state_address, sensed.ctypes.data, answer.ctypes.data)
        # The first word is the size; a negative one requests a stop.
        if answer[0] < 0 or kept.count >= kept.capacity:
            return
        if kept.skipped > 0:
            kept.skipped -= 1
            return
        kept.skipped = kept.every - 1
        currents = kept.rows_address + kept.count * (kept.sense_size + kept.currents_size + kept.command_size)
        copy_bytes(sensed.ctypes.data, currents, kept.sense_size)
        currents += kept.sense_size
        # The Sense has only their address, at which the next step writes others.
        copy_bytes(sensed[kept.currents_place], currents, kept.currents_size)
        copy_bytes(answer.ctypes.data, currents + kept.currents_size, kept.command_size)
        kept.count += 1

    return numba.cfunc(step_signature(RECORDER, _WORD, _WORD), cache=KEEPS_CACHE)(record_step)


@cache
def playing_step() -> Any:
    """Return the step that answers with recorded commands, compiled; after the last one it requests a stop.

    Result: its `address` is that of a step function of any contract, whose state is a PLAYER. The caller must retain
    it.
    """

    def play_step(player: Any, _sense: Any, command: Any) -> None:
        state = carray(player, 1)[0]
        answer = carray(command, 1)
        if state.given >= state.count:
            answer[0] = STOP
            return
        # The first word is the size of the record, which the loop has set.
        first = state.commands_address + state.size * state.given + 8
        copy_bytes(first, answer.ctypes.data + 8, state.size - 8)
        state.given += 1

    return numba.cfunc(step_signature(_PLAYER, _WORD, _WORD), cache=KEEPS_CACHE)(play_step)


def player_of(commands: NDArray[Any]) -> NDArray[Any]:
    """Make the state of a playing step.

    `commands`, shape (n,): the commands, as records of their contract, contiguous; they have to outlive the state.
    """
    return np.array([(commands.ctypes.data, commands.itemsize, len(commands), 0)], _PLAYER)
