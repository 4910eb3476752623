"""Reading files that strangers name: regular ones alone, without waiting for anything, and within a bound."""

import errno
import os
import stat
from pathlib import Path
from typing import Final

LARGEST_FILE_BYTES: Final = 256 * 2**20
"""Greatest size of one file of a candidate, such as an image with its debug information."""


def require_regular(status: os.stat_result, most: int = LARGEST_FILE_BYTES) -> None:
    """Raise OSError for what is not a regular file of at most `most` bytes, with a reason that follows its name."""
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
    if status.st_size > most:
        raise OSError(errno.EFBIG, f"it is larger than {most // 2**20} MiB")


def require_made(path: str | Path) -> None:
    """Raise OSError unless a tool that strangers' files may have taken over left a regular file, and no link."""
    require_regular(Path(path).lstat())


def made_content(path: str | Path) -> bytes:
    """Read a regular file that such a tool has left, after its end; a link could lead to any file."""
    require_made(path)
    return regular_content(path)


def regular_content(path: str | Path, most: int = LARGEST_FILE_BYTES) -> bytes:
    """Read a regular file of at most `most` bytes.

    A file is read as far as its size says. Files of the kernel such as ``/proc/kmsg`` have the size 0, and their
    readers would wait for news. Raises OSError for everything else, as `require_regular` does.
    """
    # Looked at first: to open a device may already have an effect, and to open a FIFO waits.
    require_regular(Path(path).stat(), most)
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY)
    with os.fdopen(descriptor, "rb") as stream:
        status = os.fstat(descriptor)
        require_regular(status, most)
        return stream.read(status.st_size)
