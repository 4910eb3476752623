"""The conformance report: one page that a reviewer reads in a browser, from the result document alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate_cases.documents.atomic_write import write_atomically

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

REPORT_FILE: Final = "report.html"
"""Name of the page in the report's folder."""
TEMPLATE: Final = "conformance.html.j2"
"""Template of the page."""


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the conformance report."""
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
    from drivegate_reports.paper.drives import is_of_paper
    from drivegate_reports.paper.facts import comparisons
    from drivegate_reports.paper.findings import recomputed_findings

    behaviour.prepare_behaviour(drive)
    shown_drive({"envelope": envelope_of(drive)}, drive)
    environment().get_template(TEMPLATE)
    if is_of_paper(drive):
        comparisons()
        recomputed_findings(of_paper_drive_only=True)


def page(document: Mapping[str, Any]) -> str:
    """Make the page."""
    from drivegate_cases.publication import facts, open_assumptions
    from drivegate_reports.conformance.behaviour import shown_behaviour
    from drivegate_reports.conformance.coverage import coverage_gaps, drive_of, evidence_of, fact_rows
    from drivegate_reports.conformance.drive import shown_drive, stated_values
    from drivegate_reports.conformance.runs import margin_figure, shown_runs
    from drivegate_reports.conformance.view import view_of
    from drivegate_reports.page.page import page_text
    from drivegate_reports.paper.drives import is_of_paper
    from drivegate_reports.paper.facts import comparisons
    from drivegate_reports.paper.findings import recomputed_findings
    from drivegate_reports.paper.verdicts import verdict_counts

    view, drive = view_of(document), drive_of(document)
    # What the paper states is of no use to who checks another drive.
    is_of_paper_drive = is_of_paper(drive)
    compared = comparisons() if is_of_paper_drive else ()
    return page_text(
        TEMPLATE,
        traces=True,
        result=view,
        drive=shown_drive(document, drive),
        behaviour=shown_behaviour(document, drive),
        runs=shown_runs(document),
        margins=margin_figure(document),
        evidence={row.id: evidence_of(row.id, drive) for row in view.checks},
        gaps=coverage_gaps(document),
        fact_rows=fact_rows() if is_of_paper_drive else (),
        is_of_paper_drive=is_of_paper_drive,
        counts=verdict_counts(compared),
        facts=[(fact, [row for row in compared if row.fact == fact.id]) for fact in facts()],
        findings=recomputed_findings(of_paper_drive_only=True) if is_of_paper_drive else (),
        assumptions=open_assumptions() if is_of_paper_drive else (),
        stated_values=() if is_of_paper_drive else stated_values(drive),
    )
