"""Memory that a candidate's process shares with its judge: records, what it is doing, and how many steps are done.

The judge copies what it reads, so that nothing changes under it, and the memory cannot be made smaller, so that
reading it never fails.

The judge can still read the progress when the process has died or hangs, so a verdict shows the step.
"""

import fcntl
import mmap
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.records import COMMAND

# With this and powers of two above it, the runs of a candidate seldom need new memory.
_SMALLEST: Final = 2**20
_LAYOUT = np.dtype([("steps", np.int64), ("activity", np.int64), ("changes", np.int64)], align=True)


def anonymous_file(size: int) -> int:
    """Make a file of a size that no process finds by a name and, on Linux, none can change; return its descriptor."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("drivegate", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.ftruncate(descriptor, size)
        # Linux ends a process that reads a page which its file no longer has (SIGBUS), so the candidate could end its
        # judge by shrinking the file. The last seal protects the other two.
        fcntl.fcntl(
            descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
        )
        return descriptor
    with tempfile.TemporaryFile(prefix="drivegate") as file:
        file.truncate(size)
        return os.dup(file.fileno())


class SharedMemory:
    """Memory for one order, and after it for the commands of one run."""

    def __init__(self, descriptor: int, size: int) -> None:
        self.descriptor = descriptor
        self.size = size
        self._memory = mmap.mmap(descriptor, size)

    @classmethod
    def create(cls, size: int) -> Self:
        """Make a new one with at least a size in bytes."""
        whole = max(_SMALLEST, 1 << (size - 1).bit_length())
        return cls(anonymous_file(whole), whole)

    def write(self, order: bytes) -> None:
        self._memory[: len(order)] = order

    def take(self, length: int) -> bytes:
        """Read an order, and leave nothing of it."""
        order = self._memory[:length]
        # An order describes what is to come in a run, and the candidate could read it here.
        self._memory[:length] = bytes(length)
        return order

    def commands(self, layout: np.dtype[Any] = COMMAND) -> NDArray[Any]:
        """Return the memory as records for commands of a layout."""
        return np.frombuffer(self._memory, layout, self.size // layout.itemsize)

    def close(self) -> None:
        """Close the descriptor; the memory itself stays readable as long as this object lives."""
        os.close(self.descriptor)


class Activity(IntEnum):
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
        return cls(anonymous_file(_LAYOUT.itemsize))

    def close(self) -> None:
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
    def marked(self, activity: Activity) -> Iterator[None]:
        """Mark the making or the deletion of an instance; a failure leaves the mark, which shows where it was."""
        self.enter(activity)
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
