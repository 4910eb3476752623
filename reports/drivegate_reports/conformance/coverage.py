"""From requirement to evidence: which runs judged a check, and what no run and no check holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate.contracts.catalogue import contract_of, on_drive
from drivegate.contracts.traceability import SPECIAL, facts_of, families_of
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.publication import facts
from drivegate_reports.page.page import clean
from drivegate_reports.paper.catalogue import FIGURES
from drivegate_reports.paper.drives import is_of_paper

FEW_RUNS: Final = 3
"""Number of runs below which a check's evidence is called thin."""
_SPECIAL: Final = frozenset(check for checks in SPECIAL.values() for check in checks)


@dataclass(frozen=True)
class Evidence:
    """What a check rests on, and which runs exercise it."""

    facts: tuple[str, ...]
    """Facts of the publication."""
    scenarios: str
    """Scenarios that it applies to, in words."""
    families: tuple[str, ...]
    """Kinds of runs that exercise it."""


@dataclass(frozen=True)
class FactRow:
    """A fact of the publication, and what holds it."""

    id: str
    title: str
    source: str
    """The fact."""
    checks: tuple[str, ...]
    """Checks of candidates."""
    properties: int
    """Number of tests of the plant and of the controllers."""
    figures: tuple[str, ...]
    """Figures of the publication that are reproduced for it."""


def drive_of(document: Mapping[str, Any]) -> DriveDocument:
    """Read the drive of a result; of one of earlier versions, which does not have it, that of its first run."""
    runs = document.get("fixed") or ()
    values = (document.get("drive") or {}).get("document") or (runs[0]["scenario"]["drive"] if runs else None)
    if values is None:
        return load_drive(DEFAULT_DRIVE)
    return parse_document(values, DriveDocument, "the result's drive")


def evidence_of(check: str, drive: DriveDocument) -> Evidence | None:
    """Look a check up, with the numbers of a drive."""
    listed = next((one for one in contract_of(drive).checks() if one.id == check), None)
    if listed is None:
        return None
    known = on_drive(listed, drive)
    families = families_of(check, drive.contract)
    return Evidence(tuple(fact.id for fact in facts_of(known)), known.scenarios, families)


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


def coverage_gaps(document: Mapping[str, Any]) -> tuple[str, ...]:
    """List what a result leaves unjudged."""
    judged = {str(check["id"]): check for check in document["checks"]}
    drive = drive_of(document)
    names = [check.id for check in contract_of(drive).checks()]
    gaps = [f"{name} is not in this result." for name in names if name not in judged]
    for name, check in judged.items():
        runs = int(check["runs"])
        if runs == 0:
            gaps.append(f"{clean(name)} was judged on no run: {clean(check['message'])}.")
        elif runs < FEW_RUNS and name not in _SPECIAL:
            gaps.append(f"{clean(name)} rests on {runs} {'run' if runs == 1 else 'runs'} only.")
    for row in fact_rows() if is_of_paper(drive) else ():
        if not row.checks:
            held = f"{row.properties} tests of the plant" if row.properties else "nothing"
            gaps.append(f"{row.id}, {row.title}, is held by no check of candidates, but by {held}.")
    return tuple(gaps)
