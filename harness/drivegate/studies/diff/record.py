"""The record of a run: a file of every step's exact inputs and commands, written and read in blocks."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate_cases.documents.wording import shown_path
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.errors import InputError
from drivegate_models.loop.exchange import OUTPUTS
from drivegate_models.loop.given_steps import SCALARS
from drivegate_models.loop.step_recording import (
    BLOCK_ROWS,
    RECORDER,
    recording_step,
    row_length,
)

_EMPTY = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_NUMBER: Final = np.dtype(np.float64)


def refuse_without_room(scenario: Scenario, folder: Path) -> None:
    """Refuse a run whose record would not fit on the disk."""
    needed = scenario.control_periods * row_length(scenario.drive.machine.phases) * _NUMBER.itemsize
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise InputError(
            f"the record of {scenario.duration_s:g} s would take {needed / 1e9:.1f} GB, but {shown_path(folder)} has "
            f"{free / 1e9:.1f} GB left; take a shorter scenario, or a folder with more room as TMPDIR"
        )


class RecordingController:
    """A controller that keeps a record of every step of another one, which has been reset.

    Attributes
    ----------
    step_address, state_address : int
        Addresses of the recorder's step and of its state; valid as long as this object lives.
    """

    def __init__(self, inner: Controller, file: BinaryIO, phases: int) -> None:
        self._inner = inner
        self._file = file
        self._length = row_length(phases)
        self._recorder: NDArray[Any] = np.zeros(1, RECORDER)
        self._step = recording_step()
        self._emptied = _EMPTY(self._empty)
        self._problem: OSError | None = None
        self._recorder[0]["phases"] = phases
        self._recorder[0]["step_address"] = inner.step_address
        self._recorder[0]["state_address"] = inner.state_address
        self._recorder[0]["empty_address"] = ctypes.cast(self._emptied, ctypes.c_void_p).value
        self.step_address: int = self._step.address
        self.state_address: int = self._recorder.ctypes.data

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if the inner controller knows."""
        return self._inner.fault

    def reset(self, nameplate: Nameplate) -> None:
        """Reset the inner controller."""
        self._inner.reset(nameplate)
        # A reset may make a controller anew.
        self._recorder[0]["step_address"] = self._inner.step_address
        self._recorder[0]["state_address"] = self._inner.state_address

    def finish(self) -> None:
        """Write what is left."""
        self._empty(None, None, None)
        if self._problem is not None:
            raise self._problem
        self._file.flush()

    def _empty(self, _recorder: int | None, _sense: int | None, _command: int | None) -> None:
        count = int(self._recorder[0]["count"])
        self._recorder[0]["count"] = 0
        try:
            self._file.write(self._recorder[0]["rows"][:count, : self._length].tobytes())
        except OSError as error:
            self._problem = error


def recorded_rows(path: Path, phases: int, end: int | None = None) -> Iterator[NDArray[np.float64]]:
    """Read a record, block by block."""
    length = row_length(phases)
    left = row_count(path, phases) if end is None else end
    with path.open("rb") as file:
        while left > 0:
            block = np.fromfile(file, np.float64, min(left, BLOCK_ROWS) * length).reshape(-1, length)
            if not len(block):
                return
            left -= len(block)
            yield block


def row_count(path: Path, phases: int) -> int:
    """Count the steps in a record."""
    return path.stat().st_size // (row_length(phases) * _NUMBER.itemsize)


def some_rows(path: Path, phases: int, begin: int, end: int) -> NDArray[np.float64]:
    """Read a few steps of a record."""
    length = row_length(phases)
    offset = begin * length * _NUMBER.itemsize
    return np.fromfile(path, np.float64, (end - begin) * length, offset=offset).reshape(-1, length)


def commands_of(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take the commands out of rows."""
    return rows[:, len(SCALARS) : len(SCALARS) + len(OUTPUTS)]
