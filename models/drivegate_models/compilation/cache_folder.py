"""The folder for compiled code: the first one that only this user can write, since numba unpickles what it finds."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

CACHE_VARIABLE: Final = "DRIVEGATE_CACHE"
"""Environment variable that overrides the folder in which compiled kernels are kept."""
NUMBA_VARIABLE: Final = "NUMBA_CACHE_DIR"
"""numba's own variable; drivegate sets it for the processes that it starts."""
KEY: Final = re.compile("[0-9a-f]{16}")
"""Name of a folder of compiled code: a key of the sources and of what compiles them."""

_ROOT: Final = 0
_WRITABLE_BY_OTHERS: Final = stat.S_IWGRP | stat.S_IWOTH


@dataclass(frozen=True)
class CacheChoice:
    """The folder for compiled code."""

    folder: Path | None
    """The folder, which exists and can be written; None if there is none."""
    refusals: tuple[str, ...]
    """Why each folder that comes earlier in the order is not used."""


def choose_folder(key: str) -> CacheChoice:
    """Choose the folder for compiled code, and create it with access for its owner alone.

    The order is: `DRIVEGATE_CACHE`, `NUMBA_CACHE_DIR`, `XDG_CACHE_HOME/drivegate`, `~/.cache/drivegate`, and
    `drivegate-UID` in the folder for temporary files. What root has compiled in an earlier one for all users, as in an
    image of a container, is copied.

    Parameters
    ----------
    key : str
        Key of the sources and of what compiles them, the name of the folder inside the first usable one.

    Returns
    -------
    CacheChoice
        The folder, and why others are not used.
    """
    refusals: dict[Path, str] = {}
    for parent, is_own in _parents():
        reason = _why_unusable(parent, key, is_own)
        if not reason:
            _copy_compiled(refusals, parent / key)
            return CacheChoice(parent / key, tuple(refusals.values()))
        refusals[parent] = f"{parent} {reason}"
    return CacheChoice(None, tuple(refusals.values()))


def _parents() -> Iterator[tuple[Path, bool]]:
    """List folders in their order, each with whether drivegate alone uses it."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        yield Path(chosen), False
    inherited = os.environ.get(NUMBA_VARIABLE)
    if inherited:
        folder = Path(inherited)
        # A process that drivegate started finds the folder of its parent, with the key.
        yield (folder.parent if KEY.fullmatch(folder.name) else folder), False
    user_cache = os.environ.get("XDG_CACHE_HOME")
    if user_cache:
        yield Path(user_cache) / "drivegate", True
    with contextlib.suppress(RuntimeError):
        yield Path.home() / ".cache" / "drivegate", True
    # Python finds no folder for temporary files where none can be written.
    with contextlib.suppress(FileNotFoundError):
        yield Path(tempfile.gettempdir()) / f"drivegate-{os.getuid()}", True


def _why_unusable(parent: Path, key: str, is_own: bool) -> str:
    """Explain why a folder cannot be used; an empty string if it can."""
    folder = parent / key
    try:
        parent.parent.mkdir(parents=True, exist_ok=True)
        for place in (parent, folder):
            with contextlib.suppress(FileExistsError):
                place.mkdir(mode=stat.S_IRWXU)
            if is_own and place == parent:
                _close_to_others(place)
            reason = _why_untrusted(place, sticky_is_safe=place == parent)
            if reason:
                return reason
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return f"cannot be written ({error.strerror})"


def _copy_compiled(parents: Iterable[Path], folder: Path) -> None:
    """Fill an empty folder with the compiled code of the first trusted one that cannot be written."""
    with contextlib.suppress(OSError):
        for parent in parents:
            source = parent / folder.name
            trusted = source.is_dir() and not any(
                _why_untrusted(place, sticky_is_safe=place == parent) for place in (parent, source)
            )
            if trusted and not any(folder.iterdir()):
                # Whole or not at all: other processes may look into the folder meanwhile.
                with tempfile.TemporaryDirectory(prefix=".copying-", dir=folder.parent) as scratch:
                    shutil.copytree(source, Path(scratch, folder.name)).rename(folder)


def _close_to_others(folder: Path) -> None:
    """Take from other users the right to write that a lax umask has granted; each folder inside is checked itself."""
    status = folder.lstat()
    if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and status.st_mode & _WRITABLE_BY_OTHERS:
        folder.chmod(stat.S_IRWXU)


def _why_untrusted(place: Path, *, sticky_is_safe: bool) -> str:
    """Explain why others could have put something into a folder; an empty string if they could not."""
    # Of a link, both it and its target count.
    found = place.stat()
    if not {place.lstat().st_uid, found.st_uid} <= {_ROOT, os.getuid()}:
        return "belongs to another user"
    if found.st_mode & _WRITABLE_BY_OTHERS and not (sticky_is_safe and found.st_mode & stat.S_ISVTX):
        return "can be written by other users"
    return ""
