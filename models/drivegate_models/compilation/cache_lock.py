"""A lock by which one process compiles a kernel, while others that need it wait for it.

The file of the locks is next to the folder of compiled kernels. A candidate reads that folder, and whoever can read a
file can lock it, too.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final

SUFFIX: Final = ".compiling"
"""What the name of the file of the locks ends with, after that of the folder."""
_PATIENCE: Final = 120.0
"""Time that a process waits for others altogether (s); two that compile the same only lose time."""
_SHORTEST, _LONGEST = 0.001, 0.05

_left: Final = [_PATIENCE]


@contextlib.contextmanager
def alone(task: str, folder: str | None) -> Iterator[None]:
    """Lock out other processes that share a folder from a task, unless there is no such lock.

    No two processes wait for each other, since functions do not call one another in a circle. `folder`: that of the
    compiled kernels; None if this process writes none.
    """
    descriptor = _lock_file(folder)
    if descriptor is None:
        yield
        return
    # Each task locks a byte of the file, which need not have so many.
    # Seven bytes, since the place of a lock in a file is a signed number of 64 bits.
    place = int.from_bytes(hashlib.sha256(task.encode()).digest()[:7])
    _wait_for(descriptor, place)
    try:
        yield
    finally:
        # Some network file systems have no locks. Then two processes may compile the same, which costs only time.
        with contextlib.suppress(OSError):
            fcntl.lockf(descriptor, fcntl.LOCK_UN, 1, place)


def _wait_for(descriptor: int, place: int) -> None:
    """Lock a byte, or go on without the lock where it is held for too long."""
    began, pause = time.monotonic(), _SHORTEST
    with contextlib.suppress(OSError):
        while True:
            try:
                fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)
                break
            except (BlockingIOError, PermissionError):
                if time.monotonic() - began > _left[0]:
                    break
            time.sleep(pause)
            pause = min(2.0 * pause, _LONGEST)
    _left[0] = max(_left[0] - (time.monotonic() - began), 0.0)


@cache
def _lock_file(folder: str | None) -> int | None:
    """Open the file of the locks once, since closing it releases all; None if this process writes no compiled code."""
    if folder is None:
        return None
    with contextlib.suppress(OSError):
        return os.open(Path(folder).with_name(Path(folder).name + SUFFIX), os.O_RDWR | os.O_CREAT, 0o600)
    return None


# A copy of a process has no locks, and may have closed the file.
os.register_at_fork(after_in_child=_lock_file.cache_clear)
