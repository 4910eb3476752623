"""Resetting a controller in mid-run, called from the compiled loop."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from struct import Struct
from typing import Any, Final

import numpy as np

from drivegate.candidates.controller import Controller
from drivegate_models.contract.outer_loop.records import STOP
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.loop.restarting import Restarts, no_restarts

_CALLED: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_STOP: Final = Struct("=q").pack(STOP)


class Restarter:
    """Resets one controller at steps of its run, and stops the run where that fails.

    Attributes
    ----------
    failure : BaseException or None
        What the reset raised that stopped the run.
    """

    def __init__(self, controller: Controller, nameplate: Nameplate) -> None:
        self._controller = controller
        self._nameplate = nameplate
        self._called: Any = _CALLED(self._restart)
        self.failure: BaseException | None = None

    def let_go(self) -> None:
        """Keep the controller no longer than its run: the callback and its owner would hold each other."""
        del self._controller, self._called

    def restarts(self, steps: Sequence[int]) -> Restarts:
        """Give what the loop takes; valid as long as this object lives."""
        if not steps:
            return no_restarts()
        address = ctypes.c_void_p.from_address(ctypes.addressof(self._called)).value or 0
        return Restarts(np.array(steps, np.int64), address)

    def _restart(self, _state: int | None, _sense: int, command: int) -> None:
        try:
            self._controller.reset(self._nameplate)
        except BaseException as failure:
            ctypes.memmove(command, _STOP, len(_STOP))
            self.failure = failure
