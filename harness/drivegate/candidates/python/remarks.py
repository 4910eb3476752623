"""Warnings of numpy and of Python in a candidate's code, such as an overflow: remarks with their line."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any, Final

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

    def _kept(self, message: Any, category: type[Warning], filename: str, lineno: int, *further: Any) -> None:
        if issubclass(category, RuntimeWarning) and len(self._lines) < MOST_REMARKS:
            file = Path(filename)
            shown = file.relative_to(self._folder) if file.is_relative_to(self._folder) else file
            self._lines[bounded_reason(f"{shown}, line {lineno}: {message}")] = None
        self._show(message, category, filename, lineno, *further)

    def lines(self) -> tuple[str, ...]:
        """Return what was warned of in this process so far."""
        return tuple(self._lines)
