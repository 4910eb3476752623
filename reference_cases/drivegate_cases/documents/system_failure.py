"""Failures of the system that drivegate runs on, in one sentence: they are no faults of drivegate."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Final, TypeGuard

_OF_THE_DISK: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO)
_WITHOUT_LOCKS: Final = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EINVAL)
_OF_THE_MACHINE: Final = (errno.EMFILE, errno.ENFILE, errno.EAGAIN)


def is_of_the_disk(error: BaseException) -> TypeGuard[OSError]:
    """Return True if a disk is full, read-only or broken."""
    return isinstance(error, OSError) and error.errno in _OF_THE_DISK


def disk_failure(error: BaseException | None) -> OSError | None:
    """Return the failure of a disk that an error is, or that it was raised from."""
    while error is not None and not is_of_the_disk(error):
        error = error.__cause__
    return error


def is_without_locks(error: OSError) -> bool:
    """Return True if a file system has no file locks, as some of networks and containers."""
    return error.errno in _WITHOUT_LOCKS


def refusal_by_system(error: BaseException) -> str | None:
    """Return a sentence about what the system lacks: disk, processes, files or the working folder."""
    full = disk_failure(error)
    if full is not None:
        place = f" at {full.filename}" if full.filename else ""
        return f"cannot write{place}: {full.strerror}; make room, or name a place on another disk"
    if isinstance(error, OSError) and error.errno in _OF_THE_MACHINE:
        return f"the system refuses to continue: {error.strerror}; raise the limit (ulimit -a) or free the resource"
    if isinstance(error, FileNotFoundError) and not _has_working_folder():
        return "the working folder no longer exists; change to another one with cd"
    return None


def _has_working_folder() -> bool:
    try:
        Path.cwd()
    except FileNotFoundError:
        return False
    return True
