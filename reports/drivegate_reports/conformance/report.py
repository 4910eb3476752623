"""The conformance report: one page that a reviewer reads in a browser, from the result document alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.laboratory import PUBLICATION_GROUP, find_in_laboratory
from drivegate_cases.documents.atomic_write import write_atomically

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

REPORT_FILE: Final = "report.html"
TEMPLATE: Final = "conformance.html.j2"


def write(document: Mapping[str, Any], folder: Path) -> Path:
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def prepare(drive: DriveDocument) -> None:
    """Import, compute and draw what every page on a drive needs, while its candidate is still being checked."""
    from drivegate.drives.envelope_document import envelope_of
    from drivegate_reports.conformance import (
        behaviour,
        runs,  # noqa: F401  (loaded early)
    )
    from drivegate_reports.conformance.drive import shown_drive
    from drivegate_reports.page.page import environment

    behaviour.prepare_behaviour(drive)
    shown_drive({"envelope": envelope_of(drive)}, drive)
    environment().get_template(TEMPLATE)
    publication = _publication_of(drive)
    if publication is not None:
        publication.prepare()


def page(document: Mapping[str, Any]) -> str:
    from drivegate_reports.conformance import words
    from drivegate_reports.conformance.behaviour import shown_behaviour
    from drivegate_reports.conformance.coverage import coverage_gaps, drive_of, evidence_of, own_rows_of
    from drivegate_reports.conformance.drive import shown_drive, stated_values
    from drivegate_reports.conformance.runs import margin_figure, shown_runs
    from drivegate_reports.conformance.view import page_values
    from drivegate_reports.page.page import page_text

    values, drive, own = page_values(document), drive_of(document), own_rows_of(document)
    publication = _publication_of(drive)
    uncovered = () if publication is None else publication.uncovered_facts()
    return page_text(
        TEMPLATE,
        traces=True,
        words=words,
        **values,
        drive=shown_drive(document, drive),
        behaviour=shown_behaviour(document, drive),
        runs=shown_runs(document),
        margins=margin_figure(document),
        evidence={check: evidence_of(check, drive, own) for check in values["check_of"]},
        gaps=(*coverage_gaps(document), *uncovered),
        paper=None if publication is None else publication.sections(),
        stated_values=stated_values(drive) if publication is None else (),
    )


def _publication_of(drive: DriveDocument) -> Any | None:
    """Return what the laboratory knows of the paper, where the drive is the paper's; to others it is of no use."""
    publication = find_in_laboratory(PUBLICATION_GROUP, "paper")
    return publication if publication is not None and publication.is_about(drive) else None
