"""What writes reports: entry points of installed packages, which the harness finds by name and imports none of."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from threading import Thread
from typing import Any, Final, TypeAlias

from drivegate.candidates.fault import bounded_line
from drivegate.gate.events import CheckStarted, Event, RunDone
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import HarnessFault

REPORT_GROUP: Final = "drivegate.reports"
"""Group of entry points, each a function of the result document and a folder that returns what it wrote."""
COMPARISON_GROUP: Final = "drivegate.comparison_reports"
"""Group of entry points, each a function of the comparison document and a folder that returns what it wrote."""
DRIVE_COMPARISON_GROUP: Final = "drivegate.drive_comparison_reports"
"""Group of entry points, each a function of the document of a comparison of drives and a folder, in the same way."""
CAMPAIGN_GROUP: Final = "drivegate.campaign_reports"
"""Group of entry points, each a function of the campaign's summary and a folder that returns what it wrote."""
CODE_COVERAGE_GROUP: Final = "drivegate.code_coverage_reports"
"""Group of entry points, each a function of what runs reached of a candidate's code and a folder, in the same way."""

WriteReport: TypeAlias = Callable[[dict[str, Any], Path], Path]
"""From a document and an existing folder to the page that was written."""
LoadWriter: TypeAlias = Callable[[], WriteReport]
"""Imports what writes a report, only when it is to be written."""


@dataclass(frozen=True)
class WrittenReports:
    """What has become of reports."""

    pages: Mapping[str, Path]
    """What was written, relative to the folder, by the report's name."""
    errors: Mapping[str, Exception]
    """What was raised where a report could not be written, by its name."""

    def problems(self, verb: str = "written") -> list[str]:
        """State each report that could not be written, and why."""
        return [
            f"the report '{one_line(name)}' could not be {verb} ({bounded_line(f'{type(error).__name__}: {error}')})"
            for name, error in self.errors.items()
        ]

    def require_all(self, verb: str = "written") -> None:
        """Raise for the first report that could not be written."""
        for problem, error in zip(self.problems(verb), self.errors.values(), strict=True):
            raise HarnessFault(problem) from error


def report_points(group: str = REPORT_GROUP) -> dict[str, EntryPoint]:
    """Find the reports that installed packages offer."""
    return {point.name: point for point in sorted(entry_points(group=group), key=lambda point: point.name)}


def page_name(load: LoadWriter) -> str | None:
    """Return the name of the page that a report writes, where its module states it as ``REPORT_FILE``."""
    name = _stated(load, "REPORT_FILE")
    return name if isinstance(name, str) else None


def preparation(load: LoadWriter) -> Callable[[DriveDocument], object] | None:
    """Return what prepares a report on a drive, where its module has a function ``prepare``."""
    prepare = _stated(load, "prepare")
    return prepare if callable(prepare) else None


def _stated(load: LoadWriter, name: str) -> object:
    """Look a name up in the module of a writer; one that cannot be loaded fails when its report is written."""
    with suppress(Exception):
        return getattr(sys.modules[load().__module__], name, None)
    return None


def write_reports(
    document: dict[str, Any], folder: Path, writers: Mapping[str, LoadWriter]
) -> WrittenReports:
    """Have reports written in their order; one that cannot be written stops no other, and leaves no part of itself."""
    pages: dict[str, Path] = {}
    errors: dict[str, Exception] = {}
    for name, load in writers.items():
        before = set(folder.rglob("*"))
        try:
            # Standard output belongs to the command.
            with redirect_stdout(sys.stderr):
                page = Path(load()(document, folder))
            pages[name] = page.resolve().relative_to(folder.resolve())
        except Exception as error:
            errors[name] = error
            for part in sorted(set(folder.rglob("*")) - before, reverse=True):
                with suppress(OSError):
                    part.rmdir() if part.is_dir() else part.unlink()
    return WrittenReports(pages, errors)


class Preparation:
    """Prepares reports on drives in threads, which leave the result and the pages unchanged."""

    def __init__(self, writers: Mapping[str, LoadWriter]) -> None:
        self._writers = writers
        self._threads: dict[DriveDocument, Thread] = {}

    def following(self, events: Iterable[Event]) -> Iterator[Event]:
        """Pass the events of a check on, and begin at its first run, when all kernels are compiled."""
        drive: DriveDocument | None = None
        for event in events:
            if isinstance(event, CheckStarted):
                drive = None if event.plan is None else event.plan.drive
            elif isinstance(event, RunDone) and drive is not None and drive not in self._threads:
                self._threads[drive] = Thread(target=self._prepare, args=(drive,), daemon=True)
                self._threads[drive].start()
            yield event

    def wait(self) -> None:
        for thread in self._threads.values():
            thread.join()

    def _prepare(self, drive: DriveDocument) -> None:
        for load in self._writers.values():
            prepare = preparation(load)
            # Whatever is wrong is reported when the page is written.
            with suppress(Exception):
                if prepare is not None:
                    prepare(drive)
