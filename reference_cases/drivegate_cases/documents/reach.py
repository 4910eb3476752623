"""Where the files lie that a stranger's document may name: in its own folder, or in a root that the user names.

Everything that a manifest names is looked up here, after symbolic links are resolved. drivegate opens these files
itself, outside of any isolation, and lets the candidate read them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fnmatch import translate
from pathlib import Path, PurePath
from typing import Final

from drivegate_cases.documents.regular_file import require_regular
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

MOST_MATCHES: Final = 1000
"""Greatest number of files that one pattern may match."""
_MOST_ENTRIES: Final = 100_000
"""Greatest number of files and folders that are looked at for one pattern."""
_ANY_FOLDERS: Final = "**"


@dataclass(frozen=True)
class Reach:
    """What a document in a folder may name."""

    folder: Path
    """The document's folder, without symbolic links; relative paths start there."""
    roots: tuple[Path, ...] = ()
    """Further folders that the user names, without symbolic links."""

    @classmethod
    def of(cls, folder: Path, roots: Iterable[str]) -> Reach:
        # Of a file, the folder that it is in would be opened too.
        return cls(folder.resolve(), tuple(Path(root).resolve() for root in roots if Path(root).is_dir()))

    def holds(self, place: Path) -> bool:
        """Return True if a place without symbolic links may be named."""
        return any(place.is_relative_to(root) for root in (self.folder, *self.roots))

    def place(self, name: str, what: str) -> Path:
        """Return a place that the document names, without symbolic links, whether or not it exists.

        `what`: the key that names it, in words. Raises InputError for a place outside, in the same words whether or not
        something is there.
        """
        try:
            found = (self.folder / name).resolve()
        except (OSError, RuntimeError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"{what} is '{one_line(name)}', which is no path: {one_line(reason)}") from error
        if not self.holds(found):
            raise InputError(
                f"{what} is '{one_line(name)}', which leads out of the manifest's folder; name files inside it, or "
                "name another folder with --root or in DRIVEGATE_READ"
            )
        return found

    def file(self, name: str, what: str) -> Path:
        """Return a regular file that the document names, without symbolic links."""
        found = self.place(name, what)
        return existing_file(found)

    def files_matching(self, pattern: str, what: str) -> tuple[Path, ...]:
        """Find the regular files that a pattern such as ``src/**/*.c`` matches, in the order of their names."""
        parts = PurePath(pattern).parts
        if PurePath(pattern).is_absolute() or ".." in parts:
            raise InputError(
                f"the pattern '{one_line(pattern)}' in {what} leaves the manifest's folder; name files outside it one "
                "by one"
            )
        if any(_ANY_FOLDERS in part and part != _ANY_FOLDERS for part in parts):
            raise InputError(
                f"the pattern '{one_line(pattern)}' in {what} is none: '**' must be a whole part of a path"
            )
        named = f"the pattern '{one_line(pattern)}' in {what}"
        try:
            found = _matches(self.folder, parts, lambda place: self.place(str(place), named))
            files = sorted({self.file(str(match), named) for match in found})
        except (_TooMany, OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"{named} cannot be followed: {one_line(reason)}") from error
        if not 0 < len(files) <= MOST_MATCHES:
            count = "no file" if not files else f"more than {MOST_MATCHES} files"
            raise InputError(
                f"{named} matches {count} in {shown_path(self.folder)}; write one that matches the sources alone"
            )
        return tuple(files)


def existing_file(path: Path) -> Path:
    """Return a regular file of a usual size, without symbolic links."""
    where = shown_path(path)
    try:
        require_regular(path.stat())
        return path.resolve()
    except FileNotFoundError as error:
        raise InputError(f"{where} does not exist; name an existing file") from error
    except IsADirectoryError as error:
        raise InputError(f"{where} is a folder; name an existing file") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{where} cannot be read: {reason}; name an existing file") from error


class _TooMany(Exception):
    pass


def _matches(folder: Path, parts: tuple[str, ...], resolved: Callable[[Path], Path]) -> Iterator[Path]:
    """Yield the regular files that match, also through symbolic links, which `resolved` follows or refuses.

    Part by part, the folders that match so far are a set. So links that lead back into a folder cost nothing, which
    would be an endless search for one path after the other.
    """
    left = [_MOST_ENTRIES]
    folders = {folder}
    for part in parts[:-1]:
        if part == _ANY_FOLDERS:
            folders = set(_all_below(folders, left))
        else:
            folders = {resolved(place) for place in _named(folders, part, left) if place.is_dir()}
    last = parts[-1] if parts else ""
    if last == _ANY_FOLDERS:
        folders, last = set(_all_below(folders, left)), "*"
    yield from (place for place in _named(folders, last, left) if place.is_file())


def _named(folders: set[Path], part: str, left: list[int]) -> Iterator[Path]:
    fits = re.compile(translate(part)).match
    return (folder / entry.name for folder in folders for entry in _entries(folder, left) if fits(entry.name))


def _all_below(folders: set[Path], left: list[int]) -> Iterator[Path]:
    """Yield folders and all that are in them; a symbolic link to a folder is not followed."""
    waiting, seen = list(folders), set(folders)
    while waiting:
        folder = waiting.pop()
        yield folder
        inner = {Path(entry.path) for entry in _entries(folder, left) if entry.is_dir(follow_symlinks=False)}
        waiting += inner - seen
        seen |= inner


def _entries(folder: Path, left: list[int]) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as found:
            entries = []
            for entry in found:
                left[0] -= 1
                if left[0] < 0:
                    raise _TooMany(f"it goes through more than {_MOST_ENTRIES} files and folders")
                entries.append(entry)
            return entries
    except PermissionError:
        return []
