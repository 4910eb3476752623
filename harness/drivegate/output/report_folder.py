"""The folder of a report: made next to its place, renamed onto it when complete, and nobody else's touched."""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from drivegate.output.file_lock import LockedElsewhere, locked_file
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.system_failure import disk_failure
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

MARK: Final = ".drivegate-report.json"
"""File by which drivegate knows its own folder, and which files in it are its own."""


class ReportFolder:
    """A folder that is written as a whole or not at all.

    Files that others have put into an earlier report's folder are kept.
    """

    def __init__(self, place: Path) -> None:
        try:
            self.place = place.resolve()
            working = Path.cwd()
            if self.place == working or self.place in working.parents:
                raise _refused(place, "holds the working folder; name a folder inside it")
            if self.place.exists() and not self.place.is_dir():
                raise _refused(place, "is a file; name a folder")
            if self.place.is_dir() and any(self.place.iterdir()) and not (self.place / MARK).is_file():
                raise _refused(
                    place, "holds files that are no report of drivegate; name a new or an empty folder"
                )
        except (OSError, ValueError, RuntimeError) as error:
            raise _unusable(place, error) from error
        self.staging = self.place.with_name(f".{self.place.name}.{secrets.token_hex(6)}.partial")
        self._shown = place
        self._made: list[Path] = []
        self._lock = -1
        self._is_committed = False

    def __enter__(self) -> Self:
        """Make the staging folder, and the folders above it that are missing."""
        try:
            missing = [parent for parent in self.staging.parents if not parent.exists()]
            for parent in reversed(missing):
                parent.mkdir()
                self._made.insert(0, parent)
            self._lock = locked_file(self._lock_file)
            self._recover()
            self.staging.mkdir()
        except LockedElsewhere as error:
            self._leave()
            why = "is being written by another drivegate; wait for its end, or name another folder"
            raise _refused(self._shown, why) from error
        except OSError as error:
            self._leave()
            raise _unusable(self._shown, error) from error
        except BaseException:
            self._leave()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove what was not committed; a failure of the disk names the folder."""
        self._leave(discard=self.staging.exists())
        full = disk_failure(error)
        if full is not None:
            kept = "what was complete is kept" if self._is_committed else "nothing was kept"
            raise unwritable(self._shown, full, kept) from error

    def _recover(self) -> None:
        """Remove what a killed process has left, and put an earlier report back that it had moved away.

        Whoever has the lock is the only one who writes here.
        """
        name = re.escape(self.place.name)
        for left in self.place.parent.iterdir():
            if re.fullmatch(rf"\.{name}\.[0-9a-f]{{12}}\.(partial|former)", left.name):
                if left.suffix == ".former" and not self.place.exists():
                    left.rename(self.place)
                else:
                    shutil.rmtree(left, ignore_errors=True)

    @property
    def _lock_file(self) -> Path:
        return self.place.with_name(f".{self.place.name}.lock")

    def _leave(self, *, discard: bool = True) -> None:
        if self._lock >= 0:
            self._lock_file.unlink(missing_ok=True)
            os.close(self._lock)
            self._lock = -1
        if discard:
            shutil.rmtree(self.staging, ignore_errors=True)
            for folder in self._made:
                with suppress(OSError):
                    folder.rmdir()

    def commit(self) -> None:
        """Put the folder into its place."""
        own = _files_in(self.staging)
        former = self.staging.with_suffix(".former")
        try:
            self._keep_foreign_files()
            _write_mark(self.staging, own)
            if self.place.exists():
                self.place.rename(former)
            try:
                self.staging.rename(self.place)
            except OSError:
                if former.exists():
                    former.rename(self.place)
                raise
        except OSError as error:
            raise _unusable(self._shown, error) from error
        self._is_committed = True
        shutil.rmtree(former, ignore_errors=True)

    @contextmanager
    def adding(self) -> Iterator[Path]:
        """Write further files into a folder of their own; at its end they join those that were committed."""
        try:
            self.staging.mkdir()
            yield self.staging
            added = _files_in(self.staging)
            # Marked first: a file that is not there yet does no harm.
            _write_mark(self.place, sorted({*_own_files(self.place), *added}))
            for name in added:
                self._make_folders_of(name)
                (self.staging / name).replace(self.place / name)
        except OSError as error:
            raise _unusable(self._shown, error) from error

    def _make_folders_of(self, name: str) -> None:
        """Make the folders that a file of the report is in, in place of links that lead elsewhere."""
        for above in reversed(Path(name).parents[:-1]):
            if (self.place / above).is_symlink():
                (self.place / above).unlink()
            (self.place / above).mkdir(exist_ok=True)

    def _keep_foreign_files(self) -> None:
        """Copy what others have put into the earlier folder."""
        if not self.place.exists():
            return
        own = {MARK, *_own_files(self.place)}
        for path in sorted(self.place.rglob("*")):
            relative = path.relative_to(self.place)
            copy = self.staging / relative
            if path.is_dir() and not path.is_symlink():
                continue
            if relative.as_posix() not in own and not copy.exists():
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, copy, follow_symlinks=False)


def _files_in(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir())


def _write_mark(folder: Path, own: list[str]) -> None:
    text = json.dumps({"schema": 1, "files": own}, indent=2)
    write_atomically(folder / MARK, f"{text}\n")


def _own_files(folder: Path) -> list[str]:
    """Read the mark; one that cannot be read owns nothing, so that nothing is lost."""
    try:
        mark = json.loads((folder / MARK).read_text(encoding="utf-8"))
        return [str(name) for name in mark["files"]]
    except (OSError, ValueError, RecursionError, TypeError, KeyError):
        return []


def unwritable(place: Path, full: OSError, kept: str) -> InputError:
    """Make the sentence about a disk that is full, read-only or broken; `kept` states what is there all the same."""
    reason = one_line(full.strerror or str(full))
    return _refused(
        place, f"cannot be written: {reason}; {kept}, so make room or name a folder on another disk"
    )


def _refused(place: Path, why: str) -> InputError:
    return InputError(f"--output {shown_path(place)} {why}")


def _unusable(place: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    return _refused(place, f"cannot be written: {one_line(reason)}; name a folder in a writable one")
