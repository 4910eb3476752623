"""The folder for compiled code: the first one that only this user can write, because numba unpickles its files."""

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

from drivegate_models.compilation.kernel_files import remove_unlisted

CACHE_VARIABLE: Final = "DRIVEGATE_CACHE"
"""Environment variable that overrides the folder for compiled kernels."""
NUMBA_VARIABLE: Final = "NUMBA_CACHE_DIR"
"""numba's own variable; drivegate sets it for the processes that it starts."""
KERNELS_VARIABLE: Final = "DRIVEGATE_KERNELS"
"""Environment variable with the folder from which a candidate's process reads compiled kernels; it writes none."""
KEY: Final = re.compile("[0-9a-f]{16}")
"""Name of a folder of compiled code: a key of the sources and of the compiler's versions."""

PACKAGED: Final = Path(__file__).resolve().parents[1] / "compiled"
"""Folder with the compiled kernels that a wheel may carry, in a folder for each key."""
_ROOT: Final = 0
_WRITABLE_BY_OTHERS: Final = stat.S_IWGRP | stat.S_IWOTH


@dataclass(frozen=True)
class CacheChoice:
    """The folder for compiled code."""

    folder: Path | None
    """The folder, which exists and can be written; None if there is none."""
    refusals: tuple[str, ...]
    """The reason why each earlier folder in the order is not used."""


def choose_folder(key: str) -> CacheChoice:
    """Choose the folder for compiled code, and create it with access for its owner alone.

    The order is: `DRIVEGATE_CACHE`, `NUMBA_CACHE_DIR`, `XDG_CACHE_HOME/drivegate`, `~/.cache/drivegate`, and
    `drivegate-UID` in the folder for temporary files. An empty folder is filled with copies of code that root has
    compiled in an earlier one for all users, for example in a container image, or that was installed with drivegate.

    `key`: key of the sources and of the compiler's versions, used as the folder's name inside the first usable one.
    Result: the folder, and the reasons why others are not used.
    """
    refusals: dict[Path, str] = {}
    for parent, is_own in _parents():
        reason = _why_unusable(parent, key, is_own)
        if not reason:
            _copy_compiled((*refusals, PACKAGED), parent / key)
            return CacheChoice(parent / key, tuple(refusals.values()))
        refusals[parent] = f"{parent} {reason}"
    return CacheChoice(None, tuple(refusals.values()))


def _parents() -> Iterator[tuple[Path, bool]]:
    """Yield folders in their order, each with True if only drivegate uses it."""
    chosen = os.environ.get(CACHE_VARIABLE)
    if chosen:
        yield Path(chosen), False
    inherited = os.environ.get(NUMBA_VARIABLE)
    if inherited:
        folder = Path(inherited)
        # A process started by drivegate inherits the folder of its parent, with the key.
        yield (folder.parent if KEY.fullmatch(folder.name) else folder), False
    user_cache = os.environ.get("XDG_CACHE_HOME")
    if user_cache:
        yield Path(user_cache) / "drivegate", True
    with contextlib.suppress(RuntimeError):
        yield Path.home() / ".cache" / "drivegate", True
    # Python raises this if no folder for temporary files can be written.
    with contextlib.suppress(FileNotFoundError):
        yield Path(tempfile.gettempdir()) / f"drivegate-{os.getuid()}", True


def _why_unusable(parent: Path, key: str, is_own: bool) -> str:
    """Return the reason why a folder cannot be used; an empty string if it can."""
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
    """Fill an empty folder with the compiled code of the first trusted folder that has some."""
    with contextlib.suppress(OSError):
        for parent in parents:
            source = parent / folder.name
            trusted = source.is_dir() and not any(
                _why_untrusted(place, sticky_is_safe=place == parent) for place in (parent, source)
            )
            if trusted and not any(folder.iterdir()):
                # Copy atomically: other processes may read the folder meanwhile.
                with tempfile.TemporaryDirectory(prefix=".copying-", dir=folder.parent) as scratch:
                    copied = shutil.copytree(source, Path(scratch, folder.name))
                    if parent == PACKAGED:
                        remove_unlisted(copied)
                    copied.rename(folder)


def _close_to_others(folder: Path) -> None:
    """Revoke other users' write permission from a lax umask; folders inside are checked separately."""
    status = folder.lstat()
    if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and status.st_mode & _WRITABLE_BY_OTHERS:
        folder.chmod(stat.S_IRWXU)


def _why_untrusted(place: Path, *, sticky_is_safe: bool) -> str:
    """Return the reason why others could have written into a folder; an empty string if they could not."""
    # For a link, both the link and its target count.
    found = place.stat()
    if not {place.lstat().st_uid, found.st_uid} <= {_ROOT, os.getuid()}:
        return "belongs to another user"
    if found.st_mode & _WRITABLE_BY_OTHERS and not (sticky_is_safe and found.st_mode & stat.S_ISVTX):
        return "can be written by other users"
    return ""
