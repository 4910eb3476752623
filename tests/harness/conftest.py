"""What the tests of the harness share: controllers with one law broken on purpose, and an eye on processes."""

import ctypes
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import psutil
import pytest
from tests.harness.beside_templates import children

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.fault import Fault
from drivegate.isolation.layers import ISOLATION_VARIABLE
from drivegate.isolation.system_calls import control_process
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES

STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
# Number of the option in linux/prctl.h.
_SET_CHILD_SUBREAPER = 36
_PATIENCE = 2.0
Alter = Callable[[Any, Any], None]


class AlteredController:
    """A built-in controller whose commands are altered after every step."""

    def __init__(self, name: str, alter: Alter) -> None:
        self._inner = BuiltinController(SEARCHES[name])
        self._inner_step = STEP(self._inner.step_address)
        self._alter = alter
        self._callback = STEP(self._step)
        self.step_address = ctypes.cast(self._callback, ctypes.c_void_p).value or 0
        self.state_address = self._inner.state_address
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        self._inner.reset(nameplate)

    def _step(self, state: int, sense: int, command: int) -> None:
        self._inner_step(state, sense, command)
        sense_record = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sense), SENSE)
        command_record = np.frombuffer((ctypes.c_char * COMMAND.itemsize).from_address(command), COMMAND)
        self._alter(sense_record[0], command_record[0])


@pytest.fixture
def altered() -> Callable[[str, Alter], AlteredController]:
    """Make a controller from the name of a built-in one and a function of Sense and Command."""
    return AlteredController


@pytest.fixture
def no_process_left() -> Iterator[None]:
    """Hold a test to leaving no process but those of before and what they start, as the session's browser does."""
    before = children()
    # Adopts what lost its own parent, which would not be among the children otherwise.
    if sys.platform.startswith("linux"):
        control_process(_SET_CHILD_SUBREAPER, 1)
    yield
    left = [child for child in children() if child not in before and not _descends_from(before, child)]
    until = time.monotonic() + _PATIENCE
    # What is being killed needs a moment on a busy machine.
    while (left := [child for child in left if not _has_ended(child)]) and time.monotonic() < until:
        time.sleep(0.02)
    assert left == [], "a worker process is left"


def _has_ended(process: psutil.Process) -> bool:
    """Return True if a process has ended, also if nobody has reaped it yet."""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def _descends_from(processes: list[psutil.Process], process: psutil.Process) -> bool:
    """Return True if one of these started a process, itself or through others, or if the process has ended since."""
    try:
        return any(parent in processes for parent in process.parents())
    except psutil.NoSuchProcess:
        return True


@pytest.fixture
def little_shrunk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make counterexamples little simpler, where that is not the subject: it takes most runs of a check that fails."""
    monkeypatch.setattr("drivegate.gate.shrinking.BUDGET", {"quick": 3})


@pytest.fixture
def not_isolated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let candidates reach the machine, so that a test sees what they do there."""
    monkeypatch.setenv(ISOLATION_VARIABLE, "none")
