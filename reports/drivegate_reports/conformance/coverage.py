"""From requirement to evidence: which runs judged a check, and what no run judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.contracts.catalogue import checks_of, contract_of, on_drive
from drivegate.contracts.traceability import SPECIAL, facts_of, families_of
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.requirements.file import OwnRequirements, RequirementsFile
from drivegate_models.errors import InputError
from drivegate_reports.page.page import clean

FEW_RUNS: Final = 3
"""Number of runs below which a check's evidence is called thin."""
_SPECIAL: Final = frozenset(check for checks in SPECIAL.values() for check in checks)


@dataclass(frozen=True)
class Evidence:
    """What a check is based on, and which runs exercise it."""

    facts: tuple[str, ...]
    scenarios: str
    """Scenarios that it applies to, in words."""
    families: tuple[str, ...]
    """Kinds of runs that exercise it."""


def drive_of(document: Mapping[str, Any]) -> DriveDocument:
    """Read the drive of a result; of one of earlier versions, which does not have it, that of its first run."""
    runs = document.get("fixed") or ()
    values = (document.get("drive") or {}).get("document") or (runs[0]["scenario"]["drive"] if runs else None)
    if values is None:
        return load_drive(DEFAULT_DRIVE)
    return parse_document(values, DriveDocument, "the result's drive")


def own_rows_of(document: Mapping[str, Any]) -> Declaration:
    """Read the user's rows that a result was judged by; one that cannot be read is left out with all others."""
    tables = [check["row"] for check in document["checks"] if check.get("row") is not None]
    if not tables:
        return NOTHING_DECLARED
    try:
        file = parse_document({"schema": 1, "requirement": tables}, RequirementsFile, "the result's rows")
    except InputError:
        return NOTHING_DECLARED
    return Declaration(requirements=OwnRequirements(file.requirement))


def evidence_of(check: str, drive: DriveDocument, own: Declaration = NOTHING_DECLARED) -> Evidence | None:
    """Find what a check is based on; `own` has the user's rows."""
    listed = next((one for one in checks_of(drive, own) if one.id == check), None)
    if listed is None:
        return None
    known = on_drive(listed, drive)
    families = families_of(check, drive.contract, own)
    return Evidence(tuple(fact.id for fact in facts_of(known)), known.scenarios, families)


def coverage_gaps(document: Mapping[str, Any]) -> tuple[str, ...]:
    judged = {str(check["id"]): check for check in document["checks"]}
    drive = drive_of(document)
    names = [check.id for check in contract_of(drive).checks]
    gaps = [f"{name} is not in this result." for name in names if name not in judged]
    for name, check in judged.items():
        runs = int(check["runs"])
        if runs == 0:
            gaps.append(f"{clean(name)} was judged on no run: {clean(check['message'])}.")
        elif runs < FEW_RUNS and name not in _SPECIAL:
            gaps.append(f"{clean(name)} rests on {runs} {'run' if runs == 1 else 'runs'} only.")
    return tuple(gaps)
