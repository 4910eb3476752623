"""Warnings of numpy and of Python in a candidate's code, such as an overflow: remarks with their line."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Final, TextIO

from drivegate.candidates.fault import bounded_reason

MOST_REMARKS: Final = 20
"""Number of remarks that are kept of a process."""


class Remarks:
    """Keeps the lines at which a process warns of its arithmetic, and goes on showing what it warns of."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lines: dict[str, None] = {}
        self._show = warnings.showwarning
        warnings.showwarning = self._kept

    def _kept(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, RuntimeWarning) and len(self._lines) < MOST_REMARKS:
            place = Path(filename)
            shown = place.relative_to(self._folder) if place.is_relative_to(self._folder) else place
            self._lines[bounded_reason(f"{shown}, line {lineno}: {message}")] = None
        self._show(message, category, filename, lineno, file, line)

    def lines(self) -> tuple[str, ...]:
        """Return what was warned of in this process so far."""
        return tuple(self._lines)
