"""A lock on a file, which says who may write into a folder."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from drivegate_cases.documents.wording import one_line


class LockedElsewhere(Exception):
    """Another process has the lock; the message is what its holder has written into the file."""


def locked_file(path: Path) -> int:
    """Lock a file, which the system unlocks when this process ends, however it ends, and return its descriptor.

    Raises LockedElsewhere if another process has the lock.
    """
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            holder = os.read(descriptor, 1000).decode(errors="replace")
            os.close(descriptor)
            raise LockedElsewhere(one_line(holder.strip())) from error
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        # Its last holder removed the file between our opening and locking it.
        os.close(descriptor)
