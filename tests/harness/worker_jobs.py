"""Jobs for the tests of workers; worker processes import this module by its name."""

import ctypes
import os
import sys
import time
from typing import Any

from drivegate.candidates.fault import CandidateFault
from drivegate.containment.messages import LoadedCandidate
from drivegate_models.contract.outer_loop.records import SENSE, command_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.errors import InputError

NAMEPLATE = Nameplate(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05)
STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


def drive(loaded: LoadedCandidate, steps: int) -> float:
    """Step the candidate through a run, as the compiled loop does, and return the sum of its references."""
    controller, progress = loaded.controller(), loaded.progress
    step, command, total = STEP(controller.step_address), command_record(), 0.0
    with progress.run():
        controller.reset(NAMEPLATE)
        progress.phase_currents[:5] = 1.0
        for index in range(steps):
            progress.steps[0] = index + 1
            progress.sense[0] = (
                SENSE.itemsize,
                index * NAMEPLATE.control_period,
                100.0,
                99.0,
                5,
                progress.phase_currents.ctypes.data,
                5.0,
                48.0,
            )
            step(controller.state_address, progress.sense.ctypes.data, command.ctypes.data)
            if command[0]["struct_size"] < 0:
                raise CandidateFault(controller.fault)
            total += float(command[0]["current_reference"])
    return total


def drive_then_tell_process(loaded: LoadedCandidate, steps: int) -> tuple[float, int]:
    return drive(loaded, steps), os.getpid()


def drive_slowly(loaded: LoadedCandidate, steps: int) -> tuple[float, float, float]:
    """Drive, then take longer than a process needs to start; tell when that was."""
    began = time.monotonic()
    total = drive(loaded, steps)
    time.sleep(1.5)
    return total, began, time.monotonic()


def sleep_by_turns(loaded: LoadedCandidate, index: int) -> int:
    """Take longer for earlier jobs, so that they end in another order than they began."""
    time.sleep(0.05 * (3 - index % 4))
    return index


def surroundings(loaded: LoadedCandidate, name: str) -> tuple[str | None, str]:
    return os.environ.get(name), sys.stdin.read()


def harness_error(loaded: LoadedCandidate, payload: Any) -> None:
    raise LookupError("a mistake of the harness")


def user_error(loaded: LoadedCandidate, payload: Any) -> None:
    raise InputError("the scenario is wrong")


def unpicklable(loaded: LoadedCandidate, payload: Any) -> Any:
    return lambda: None


def stuck(loaded: LoadedCandidate, payload: Any) -> None:
    while True:
        pass
