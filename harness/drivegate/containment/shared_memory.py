"""Memory that a candidate's process shares with its judge: how far it is, the order, and the commands that it gave.

The judge copies what it reads, so that nothing changes under it, and the memory cannot be made smaller, so that
reading it never fails.
"""

import fcntl
import mmap
import os
import tempfile
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.records import COMMAND

_SMALLEST: Final = 2**20


def anonymous_file(size: int) -> int:
    """Make a file of a size that no process finds by a name and, on Linux, none can change; return its descriptor."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("drivegate", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.ftruncate(descriptor, size)
        fcntl.fcntl(
            descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
        )
        return descriptor
    with tempfile.TemporaryFile(prefix="drivegate") as file:
        file.truncate(size)
        return os.dup(file.fileno())


class SharedMemory:
    """Room for one order, and after it for the commands of one run."""

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
        """Write an order."""
        self._memory[: len(order)] = order

    def take(self, length: int) -> bytes:
        """Read an order, and leave nothing of it."""
        order = self._memory[:length]
        self._memory[:length] = bytes(length)
        return order

    def commands(self, layout: np.dtype[Any] = COMMAND) -> NDArray[Any]:
        """Return the memory as room for commands of a layout."""
        return np.frombuffer(self._memory, layout, self.size // layout.itemsize)

    def copied_commands(self, layout: np.dtype[Any], count: int) -> NDArray[Any]:
        """Copy the first commands, as far as there is room for them; shape (n,)."""
        return self.commands(layout)[:count].copy()

    def close(self) -> None:
        """Close the descriptor; the memory itself stays readable as long as this object lives."""
        os.close(self.descriptor)
