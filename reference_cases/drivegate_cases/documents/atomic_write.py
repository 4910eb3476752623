"""Writing a file so that a reader sees the old content or the new one, never a part of it."""

import contextlib
import os
import secrets
from pathlib import Path

from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

_WRONG_PLACE = (FileNotFoundError, NotADirectoryError, IsADirectoryError, PermissionError)


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write a whole file: beside its place first, flushed to the disk, then renamed onto it.

    A symbolic link is followed, so that the file it points to is replaced and the link stays.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        target = Path(path).resolve()
        partial = target.with_name(f".{secrets.token_hex(12)}.partial")
        _replace_flushed(partial, target, data)
    except (*_WRONG_PLACE, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{shown_path(path)} cannot be written: {one_line(reason)}; "
            "name a file in an existing, writable folder"
        ) from error
    except OSError as error:
        # What fails while it writes does not name the file.
        error.filename = error.filename or str(path)
        raise


def _replace_flushed(partial: Path, target: Path, data: bytes) -> None:
    """Write the file beside its place and rename it, leaving nothing beside on failure."""
    try:
        # A file that does not exist yet gets the permissions that the user's mask leaves.
        with partial.open("xb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(target)
    except BaseException:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise
    # The folder too, so that the rename itself survives a loss of power.
    descriptor = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
