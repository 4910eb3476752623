"""Memory that a worker process shares with its parent: how far the candidate is, and what it sensed last.

The parent can still read it when the worker has died or hangs, so a verdict tells the step and its inputs.
"""

import mmap
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.outer_loop.records import SENSE
from drivegate_models.contract.outer_loop.signals import Sense

MOST_PHASES: Final = 64
"""Phase currents that the shared record has room for."""

_LAYOUT = np.dtype(
    [
        ("steps", np.int64),
        ("activity", np.int64),
        ("changes", np.int64),
        ("sense", SENSE),
        ("phase_currents", np.float64, (MOST_PHASES,)),
    ],
    align=True,
)


class Activity(IntEnum):
    """What a worker process is doing."""

    STARTING = 0
    LOADING = 1
    WAITING = 2
    PREPARING = 3
    RUNNING = 4


_ACTIVITIES: Final = frozenset(int(activity) for activity in Activity)


class SharedProgress:
    """The shared memory, seen from either side.

    Attributes
    ----------
    steps : array of int64, shape (1,)
        Steps that the current run has begun; the closed loop counts each before it asks the controller.
    sense : array of SENSE, shape (1,)
        The record that the closed loop hands to the controller.
    phase_currents : array, shape (MOST_PHASES,)
        Where that record's phase currents belong (A).
    """

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        memory = mmap.mmap(descriptor, _LAYOUT.itemsize)
        whole = np.frombuffer(memory, dtype=_LAYOUT)
        self.steps: NDArray[np.int64] = whole["steps"]
        self.sense: NDArray[Any] = whole["sense"]
        self.phase_currents: NDArray[np.float64] = whole["phase_currents"][0]
        self._activity: NDArray[np.int64] = whole["activity"]
        self._changes: NDArray[np.int64] = whole["changes"]

    @classmethod
    def create(cls) -> Self:
        """Make new shared memory, which no other process finds by a name."""
        with tempfile.TemporaryFile(prefix="drivegate") as file:
            file.truncate(_LAYOUT.itemsize)
            return cls(os.dup(file.fileno()))

    def close(self) -> None:
        """Close the descriptor; the memory itself stays readable as long as this object lives."""
        os.close(self.descriptor)

    @property
    def activity(self) -> Activity:
        """What the worker is doing; only a candidate that runs writes over it, so any other number means that."""
        number = int(self._activity[0])
        return Activity(number) if number in _ACTIVITIES else Activity.RUNNING

    @property
    def state(self) -> tuple[int, int]:
        """Number of changes of activity and of steps begun; it differs once the worker has moved on."""
        return int(self._changes[0]), int(self.steps[0])

    def enter(self, activity: Activity) -> None:
        """Tell what the worker does from now on."""
        self._activity[0] = activity
        self._changes[0] += 1

    @contextmanager
    def loading(self) -> Iterator[None]:
        """Mark the making of an instance of the candidate; a failure leaves the mark."""
        self.enter(Activity.LOADING)
        yield
        self.enter(Activity.PREPARING)

    @contextmanager
    def run(self) -> Iterator[None]:
        """Mark one closed-loop run, from before the controller's reset to after its last step.

        Only what happens inside is the candidate's; a stall outside is the harness's own.
        """
        self.steps[0] = 0
        self.sense["struct_size"] = 0
        self.enter(Activity.RUNNING)
        try:
            yield
        finally:
            self.enter(Activity.PREPARING)

    def last_sense(self) -> Sense | None:
        """What the controller sensed last."""
        record = self.sense[0]
        if record["struct_size"] != SENSE.itemsize:
            return None
        phases = min(max(int(record["phase_count"]), 0), MOST_PHASES)
        values = {name: float(record[name]) for name in Sense._fields if name != "phase_currents"}
        return Sense(phase_currents=tuple(self.phase_currents[:phases].tolist()), **values)
