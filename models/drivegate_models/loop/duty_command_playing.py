"""A controller of duty ratios that plays recorded commands of another controller, whatever it senses."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

from drivegate_models.compilation.calling import copy_bytes, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import STOP
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.loop.command_playing import PLAYER

_SIZE: Final = DUTY_COMMAND.itemsize


@cache
def duty_playing_step() -> Any:
    """Return the step that plays recorded commands, compiled; after the last one it requests a stop.

    Returns
    -------
    CFunc
        Its `address` is that of a function like `drivegate_duty_step`, whose state is a PLAYER. The caller must retain
        it.
    """
    # numba must be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    signature = step_signature(PLAYER, DUTY_SENSE, DUTY_COMMAND)

    def play_duty_step(player: Any, _sense: Any, command: Any) -> None:
        state = carray(player, 1)[0]
        answers = carray(command, 1)
        if state.given >= state.count:
            answers[0].struct_size = STOP
            return
        copy_bytes(state.commands_address + _SIZE * state.given, answers.ctypes.data, _SIZE)
        state.given += 1

    return numba.cfunc(signature, cache=KEEPS_CACHE)(play_duty_step)
