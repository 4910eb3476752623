"""Temporary folders of running processes, and the removal of those whose process was killed."""

import fcntl
import os
import re
import secrets
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from drivegate_cases.documents.system_failure import is_without_locks
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_NAME: Final = re.compile(r"\.drivegate-[0-9a-f]{16}")
_swept: set[str] = set()


class TemporaryFolder:
    """A folder that is locked for as long as its process lives, however that ends.

    The first one of a process removes the folders that earlier processes could not remove.
    """

    def __init__(self) -> None:
        try:
            place = Path(tempfile.gettempdir())
            _remove_abandoned(place)
            self.path, self._lock = _locked_folder(place)
        except OSError as error:
            reason = one_line(error.strerror or str(error))
            raise InputError(
                f"no temporary folder can be made: {reason}; name a writable folder in the environment variable TMPDIR"
            ) from error

    def remove(self) -> None:
        shutil.rmtree(self.path, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


@contextmanager
def temporary_folder() -> Iterator[Path]:
    folder = TemporaryFolder()
    try:
        yield folder.path
    finally:
        folder.remove()


def _locked_folder(place: Path) -> tuple[Path, int]:
    while True:
        folder = place / f".drivegate-{secrets.token_hex(8)}"
        folder.mkdir(mode=0o700)
        # Another process may take it for abandoned between our making and locking it.
        with suppress(FileNotFoundError):
            descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                # Without waiting: whoever can read the folder above could lock it for ever in this moment.
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(descriptor)
                continue
            except OSError as error:
                # Where there are no locks, no process finds a folder abandoned either.
                if not is_without_locks(error):
                    raise
            if folder.exists():
                return folder, descriptor
            os.close(descriptor)


def _remove_abandoned(place: Path) -> None:
    """Remove this user's folders that no process has locked, once in a process."""
    if str(place) in _swept:
        return
    _swept.add(str(place))
    with os.scandir(place) as entries:
        for entry in entries:
            with suppress(OSError):
                if _NAME.fullmatch(entry.name) and entry.stat(follow_symlinks=False).st_uid == os.getuid():
                    _remove_unlocked(Path(entry.path))


def _remove_unlocked(folder: Path) -> None:
    # Others can write into the folder above: a link with such a name must not lead the removal elsewhere.
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        # This raises OSError for a folder in use, which the caller ignores.
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(descriptor)
