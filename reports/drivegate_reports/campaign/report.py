"""The page of a campaign: how often each candidate breaks each requirement, from the summary alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically

REPORT_FILE: Final = "campaign.html"
"""Name of the page in the campaign's folder."""


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the page."""
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    """Make the page."""
    from drivegate_reports.campaign.view import view_of
    from drivegate_reports.page.page import page_text

    return page_text("campaign.html.j2", view=view_of(document))
