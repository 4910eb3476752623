"""The comparison report: one page that decides between candidates, from the comparison document alone."""

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
    from drivegate.studies.compare.duty.document import DUTY_KIND
    from drivegate_reports.comparison.duty_figures import duty_figures
    from drivegate_reports.comparison.duty_view import duty_view_of
    from drivegate_reports.comparison.figures import comparison_figures
    from drivegate_reports.comparison.view import view_of
    from drivegate_reports.page.page import page_text

    if document.get("kind") == DUTY_KIND:
        of_duty = duty_view_of(document)
        return page_text("duty_comparison.html.j2", view=of_duty, figures=duty_figures(document))
    view = view_of(document)
    return page_text("comparison.html.j2", view=view, figures=comparison_figures(document))
