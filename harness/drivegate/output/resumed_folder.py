"""A folder of results that one process writes into at a time, and goes on with what is complete."""

from __future__ import annotations

import json
import os
import socket
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from drivegate.output.file_lock import LockedElsewhere, locked_file
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError


class ResumedFolder(ABC):
    """A folder of results, held for one process alone as long as the context lasts."""

    def __init__(self, place: Path, *, kind: str, manifest: str, lock: str) -> None:
        """Name the folder, what its results are called, and the files that show whose it is and who writes."""
        self.place = place
        self._kind, self._manifest, self._lock_file = kind, manifest, lock
        self._lock = -1

    @abstractmethod
    def claim(self) -> None:
        """Write the manifest, or refuse the folder because its manifest is of other results."""

    def __enter__(self) -> Self:
        """Make the folder or find it, take its lock, and see that it belongs to these results."""
        with failures_refused(self.place, "use"):
            self._refuse_foreign()
            self.place.mkdir(parents=True, exist_ok=True)
            try:
                self._lock = locked_file(self.place / self._lock_file)
            except LockedElsewhere as error:
                holder = f" ({error})" if str(error) else ""
                raise InputError(
                    f"--output {shown_path(self.place)} is being written by another {self._kind}{holder}; wait for "
                    "its end, or name another folder"
                ) from error
            os.ftruncate(self._lock, 0)
            os.write(self._lock, f"process {os.getpid()} on {socket.gethostname()}\n".encode())
        try:
            with failures_refused(self.place, "write"):
                self.claim()
                for partial in self.place.rglob(".*.partial"):
                    partial.unlink()
        except BaseException:
            self._release()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let others write into the folder."""
        self._release()

    def _refuse_foreign(self) -> None:
        if self.place.exists() and not self.place.is_dir():
            raise InputError(f"--output {shown_path(self.place)} is a file; name a folder")
        if not self.place.is_dir():
            return
        link = next((entry for entry in self.place.rglob("*") if entry.is_symlink()), None)
        if link is not None:
            raise InputError(
                f"--output {shown_path(self.place)} holds a symbolic link, '{one_line(link.name)}', through which "
                "results would be written elsewhere; remove it, or name a new folder"
            )
        if (self.place / self._manifest).exists():
            return
        if any(
            entry.name != self._lock_file and not (entry.name.startswith(".") and entry.suffix == ".partial")
            for entry in self.place.iterdir()
        ):
            raise InputError(
                f"--output {shown_path(self.place)} holds files that are no {self._kind} of drivegate; "
                "name a new or an empty folder"
            )

    def _release(self) -> None:
        with suppress(OSError):
            (self.place / self._lock_file).unlink()
        os.close(self._lock)
        self._lock = -1

    @staticmethod
    def as_json(document: Mapping[str, Any]) -> str:
        return json.dumps(document, indent=2, allow_nan=False) + "\n"

    def write(self, path: Path, content: str | bytes) -> None:
        with failures_refused(path, "write"):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(path, content)


@contextmanager
def failures_refused(path: Path, verb: str) -> Iterator[None]:
    """Turn a failure of the file system into a sentence."""
    try:
        yield
    except OSError as error:
        reason = one_line(error.strerror or str(error))
        raise InputError(
            f"{shown_path(path)} cannot be {'written' if verb == 'write' else 'used'}: {reason}; make room or name a "
            "writable folder, then run the same command again: it goes on from the files that are complete"
        ) from error
