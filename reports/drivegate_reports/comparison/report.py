"""The report of a comparison: one page that decides between candidates, from the comparison document alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically

REPORT_FILE: Final = "comparison.html"
"""Name of the page in the report's folder."""


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the comparison report."""
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    """Make the page."""
    from drivegate_reports.comparison.view import view_of
    from drivegate_reports.page.page import page_text

    return page_text("comparison.html.j2", view=view_of(document))
