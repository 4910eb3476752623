"""Resetting a controller in mid-run, called from the compiled loop."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from struct import Struct
from typing import Final

import numpy as np

from drivegate.candidates.controller import Controller
from drivegate_models.contract.outer_loop.records import STOP
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.loop.restarting import Restarts, no_restarts

_CALLED: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_STOP: Final = Struct("=q").pack(STOP)


@contextmanager
def restarting(controller: Controller, nameplate: Nameplate, times: Sequence[float]) -> Iterator[Restarts]:
    """Let a controller be reset at times of a run (s), and raise what a reset raised once the run is over."""
    if not times:
        yield no_restarts()
        return
    failures: list[BaseException] = []

    def restart(_state: int | None, _sense: int, command: int) -> None:
        try:
            controller.reset(nameplate)
        except BaseException as failure:
            ctypes.memmove(command, _STOP, len(_STOP))
            failures.append(failure)

    called = _CALLED(restart)
    steps = np.array([round(time / nameplate.control_period) for time in times], np.int64)
    yield Restarts(steps, ctypes.c_void_p.from_address(ctypes.addressof(called)).value or 0)
    if failures:
        raise failures[0]
