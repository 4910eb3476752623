"""A controller that plays recorded commands of another controller, whatever it senses."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import COMMAND, SENSE, STOP
from drivegate_models.loop.exchange import OUTPUTS

PLAYER: Final = np.dtype(
    [("commands_address", np.int64), ("count", np.int64), ("given", np.int64)], align=True
)
"""State of the playing step: the address of `count` commands, and how many were played."""


@cache
def playing_step() -> Any:
    """Return the step that plays recorded commands, compiled; after the last one it requests a stop.

    Returns
    -------
    CFunc
        Its `address` is that of a function like `drivegate_step`, whose state is a PLAYER. The caller must retain it.
    """
    # numba must be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    signature = step_signature(PLAYER, SENSE, COMMAND)

    def play_step(player: Any, _sense: Any, command: Any) -> None:
        state = carray(player, 1)[0]
        answer = carray(command, 1)[0]
        if state.given >= state.count:
            answer.struct_size = STOP
            return
        first = 3 * state.given
        answer.current_reference = double_at(state.commands_address, first)
        answer.advance_angle = double_at(state.commands_address, first + 1)
        answer.input_power = double_at(state.commands_address, first + 2)
        state.given += 1

    return numba.cfunc(signature, cache=KEEPS_CACHE)(play_step)


def rows_of(commands: NDArray[Any]) -> NDArray[np.float64]:
    """Return commands as rows of numbers.

    Parameters
    ----------
    commands : ndarray of COMMAND, shape (n,)
        Commands as a run stores them.

    Returns
    -------
    ndarray, shape (n, 3)
        `exchange.OUTPUTS` in each row (A, rad electrical, W).
    """
    return np.stack([commands[name] for name in OUTPUTS], axis=1)


def player_of(commands: NDArray[Any]) -> NDArray[Any]:
    """Return the state of a playing step of either contract.

    Parameters
    ----------
    commands : ndarray, shape (n, 3), or of DUTY_COMMAND, shape (n,)
        `exchange.OUTPUTS` in each row, or duty commands; contiguous. They must outlive the state.

    Returns
    -------
    ndarray of PLAYER, shape (1,)
        The state, before the first command.
    """
    return np.array([(commands.ctypes.data, len(commands), 0)], PLAYER)
