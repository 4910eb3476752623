"""The pages of a finished campaign, which installed packages write into its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from drivegate.output.report_writers import CAMPAIGN_GROUP, report_points, write_reports
from drivegate.output.resumed_folder import failures_refused
from drivegate.studies.campaign.folder import CampaignFolder


def write_pages(document: dict[str, Any], folder: CampaignFolder) -> tuple[Path, ...]:
    """Write every page, from the summary and the specifications of its candidates."""
    writers = {name: point.load for name, point in report_points(CAMPAIGN_GROUP).items()}
    written = write_reports(document, folder.place, writers)
    for error in written.errors.values():
        if isinstance(error, OSError):
            # A page is lost to a full disk as the results are, and made again in the same way.
            with failures_refused(folder.place, "write"):
                raise error
    written.require_all()
    return tuple(folder.place / page for page in written.pages.values())
