"""What the page of a check shows of the paper, where the drive that was checked is the paper's."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.publication import facts, open_assumptions
from drivegate_lab.paper.catalogue import FIGURES
from drivegate_lab.paper.drives import reference_drive
from drivegate_lab.paper.facts import comparisons
from drivegate_lab.paper.findings import recomputed_findings
from drivegate_lab.paper.verdicts import verdict_counts


@dataclass(frozen=True)
class FactRow:
    """A fact of the paper, and what holds it."""

    id: str
    title: str
    source: str
    """The fact."""
    checks: tuple[str, ...]
    """Checks of candidates."""
    properties: int
    """Number of tests of the plant and of the controllers."""
    figures: tuple[str, ...]
    """Figures of the paper that are reproduced for it."""


def is_about(drive: DriveDocument) -> bool:
    """Return True if a drive has the values of the paper's drive, whatever its name."""
    return bool(drive.identity()["hash"] == reference_drive().identity()["hash"])


def prepare() -> None:
    """Compute what every page shows, while a candidate is still being checked."""
    comparisons()
    recomputed_findings()


def sections() -> dict[str, Any]:
    """Return what the template of the page takes."""
    compared = comparisons()
    return {
        "fact_rows": fact_rows(),
        "counts": verdict_counts(compared),
        "facts": [(fact, [row for row in compared if row.fact == fact.id]) for fact in facts()],
        "findings": recomputed_findings(),
        "assumptions": open_assumptions(),
    }


def fact_rows() -> tuple[FactRow, ...]:
    """List the facts with what holds each."""
    labels = {figure.module: figure.label for figure in FIGURES}
    return tuple(
        FactRow(
            fact.id,
            fact.title,
            fact.source,
            fact.covered_by.checks,
            len(fact.covered_by.properties),
            tuple(labels[name] for name in fact.covered_by.figures if name in labels),
        )
        for fact in facts()
    )


def uncovered_facts() -> Iterable[str]:
    """State each fact that no check of candidates holds."""
    for row in fact_rows():
        if not row.checks:
            held = f"{row.properties} tests of the plant" if row.properties else "nothing"
            yield f"{row.id}, {row.title}, is held by no check of candidates, but by {held}."
