"""Memory that a candidate's process shares with its judge: what it is doing, and how many steps it has begun.

The judge can still read it when the process has died or hangs, so a verdict shows the step.
"""

import mmap
import os
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.shared_memory import anonymous_file

_LAYOUT = np.dtype([("steps", np.int64), ("activity", np.int64), ("changes", np.int64)], align=True)


class Activity(IntEnum):
    """What a candidate's process is doing."""

    STARTING = 0
    LOADING = 1
    WAITING = 2
    PREPARING = 3
    RUNNING = 4
    LETTING_GO = 5


_ACTIVITIES: Final = frozenset(int(activity) for activity in Activity)


class SharedProgress:
    """The shared memory, seen from either side.

    `steps`, shape (1,): steps that the current run has begun; the closed loop counts each before it asks the
    controller.
    """

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        memory = mmap.mmap(descriptor, _LAYOUT.itemsize)
        whole = np.frombuffer(memory, dtype=_LAYOUT)
        self.steps: NDArray[np.int64] = whole["steps"]
        self._activity: NDArray[np.int64] = whole["activity"]
        self._changes: NDArray[np.int64] = whole["changes"]

    @classmethod
    def create(cls) -> Self:
        """Make new shared memory, which no other process finds by a name."""
        return cls(anonymous_file(_LAYOUT.itemsize))

    def close(self) -> None:
        """Close the descriptor; the memory itself stays readable as long as this object lives."""
        os.close(self.descriptor)

    @property
    def activity(self) -> Activity:
        """What the process is doing; only a candidate that runs writes over it, so any other number means that."""
        number = int(self._activity[0])
        return Activity(number) if number in _ACTIVITIES else Activity.RUNNING

    @property
    def state(self) -> tuple[int, int]:
        """Number of changes of activity and of steps begun; it differs once the worker has moved on."""
        return int(self._changes[0]), int(self.steps[0])

    def enter(self, activity: Activity) -> None:
        """Record what the process does from now on."""
        self._activity[0] = activity
        self._changes[0] += 1

    @contextmanager
    def loading(self) -> Iterator[None]:
        """Mark the making of an instance of the candidate; a failure leaves the mark."""
        self.enter(Activity.LOADING)
        yield
        self.enter(Activity.PREPARING)

    @contextmanager
    def letting_go(self) -> Iterator[None]:
        """Mark the deletion of an instance."""
        self.enter(Activity.LETTING_GO)
        yield
        self.enter(Activity.PREPARING)

    @contextmanager
    def running(self) -> Iterator[None]:
        """Mark a reset of the controller, or its steps."""
        self.enter(Activity.RUNNING)
        try:
            yield
        finally:
            self.enter(Activity.PREPARING)
