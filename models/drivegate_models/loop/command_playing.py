"""A controller that answers with the recorded commands of another one, whatever it senses and whatever its contract."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import copy_bytes, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import STOP

PLAYER: Final = np.dtype(
    [("commands_address", np.int64), ("size", np.int64), ("count", np.int64), ("given", np.int64)], align=True
)
"""State of the playing step: the address of `count` commands, the size of each (bytes), and how many were given."""


@cache
def playing_step() -> Any:
    """Return the step that answers with recorded commands, compiled; after the last one it requests a stop.

    Returns
    -------
    CFunc
        Its `address` is that of a step function of any contract, whose state is a PLAYER. The caller must retain it.
    """
    # numba must be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    word: Any = np.dtype(np.int64)

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

    return numba.cfunc(step_signature(PLAYER, word, word), cache=KEEPS_CACHE)(play_step)


def player_of(commands: NDArray[Any]) -> NDArray[Any]:
    """Make the state of a playing step.

    Parameters
    ----------
    commands : ndarray, shape (n,)
        The commands, as records of their contract, contiguous; they have to outlive the state.

    Returns
    -------
    ndarray of PLAYER, shape (1,)
        The state, before the first command.
    """
    return np.array([(commands.ctypes.data, commands.itemsize, len(commands), 0)], PLAYER)
