"""A lock on a file, which says who may write into a folder."""

from __future__ import annotations

import fcntl
import logging
import os
from contextlib import suppress
from pathlib import Path

from drivegate_cases.documents.system_failure import is_without_locks
from drivegate_cases.documents.wording import one_line, shown_path

_log = logging.getLogger("drivegate")


class LockedElsewhere(Exception):
    """Another process has the lock; the message is what its holder has written into the file."""


def locked_file(path: Path) -> int:
    """Lock a file, which the system unlocks when this process ends, however it ends, and return its descriptor.

    On a file system without locks it warns, and goes on without one. Raises LockedElsewhere if another process has the
    lock.
    """
    while True:
        # A link, such as one in a stranger's checkout, would have a file elsewhere made or overwritten.
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            holder = os.read(descriptor, 1000).decode(errors="replace")
            os.close(descriptor)
            raise LockedElsewhere(one_line(holder.strip())) from error
        except OSError as error:
            if not is_without_locks(error):
                os.close(descriptor)
                raise
            _log.warning(
                "the file system of %s has no file locks (%s); see to it that no other drivegate writes there",
                shown_path(path.parent),
                one_line(error.strerror or str(error)),
            )
            return descriptor
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        # Its last holder removed the file between our opening and locking it.
        os.close(descriptor)
