"""Resetting a controller in mid-run, called from the compiled loop."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from struct import Struct
from typing import Final

import numpy as np

from drivegate.candidates.controller import Controller
from drivegate_models.contract.current.records import STOP
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.loop.restarting import Restarts, no_restarts

_CALLED: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_STOP: Final = Struct("=q").pack(STOP)


class Restarter:
    """Resets one controller at steps of its run, and stops the run where that fails.

    Nothing here refers to itself, so that the controller is kept no longer than this object: what a candidate does
    when its instance is deleted happens there, and not whenever Python collects cycles.

    `failures`: what the reset raised that stopped the run; empty where all went well.
    """

    def __init__(self, controller: Controller, nameplate: Nameplate) -> None:
        self.failures: list[BaseException] = []
        self._called = _CALLED(_reset_by_call(controller, nameplate, self.failures))

    def restarts(self, steps: Sequence[int]) -> Restarts:
        """Return what the loop takes; valid as long as this object lives."""
        if not steps:
            return no_restarts()
        address = ctypes.c_void_p.from_address(ctypes.addressof(self._called)).value or 0
        return Restarts(np.array(steps, np.int64), address)


def _reset_by_call(
    controller: Controller, nameplate: Nameplate, failures: list[BaseException]
) -> Callable[[int | None, int, int], None]:
    """Make what resets a controller when it is called with the arguments of a step."""

    def reset(_state: int | None, _sense: int, command: int) -> None:
        try:
            controller.reset(nameplate)
        except BaseException as failure:
            ctypes.memmove(command, _STOP, len(_STOP))
            # Without this frame, which has the list that the failure goes into.
            failures.append(failure.with_traceback(failure.__traceback__ and failure.__traceback__.tb_next))

    return reset
