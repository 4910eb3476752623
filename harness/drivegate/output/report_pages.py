"""The reports that installed packages offer, each written from the result document alone."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from pathlib import Path

from drivegate.candidates.fault import bounded_line
from drivegate.gate.events import CheckFinished, Event
from drivegate.output.report_writers import WriteReport, report_points


class ReportPages:
    """Has every installed report written.

    Attributes
    ----------
    pages : list of Path
        What was written, relative to the folder.
    problems : list of str
        What happened to each report that could not be written.
    error : Exception or None
        What the first of them raised.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.pages: list[Path] = []
        self.problems: list[str] = []
        self.error: Exception | None = None

    def __call__(self, event: Event) -> None:
        """Write when the check has ended."""
        if not isinstance(event, CheckFinished):
            return
        for point in report_points().values():
            try:
                # Standard output belongs to the command.
                with redirect_stdout(sys.stderr):
                    write: WriteReport = point.load()
                    page = Path(write(event.result.document(), self._folder))
                self.pages.append(page.resolve().relative_to(self._folder.resolve()))
            except Exception as error:
                reason = bounded_line(f"{type(error).__name__}: {error}")
                self.error = self.error or error
                self.problems.append(f"the report '{point.name}' could not be written ({reason})")
