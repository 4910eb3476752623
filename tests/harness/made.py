"""Outcomes of checks and whole results, made up for a test."""

from collections.abc import Iterable
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.results.document import (
    CandidateSection,
    CheckSection,
    DriveSection,
    FaultSection,
    ResultDocument,
)
from drivegate.results.result import content_hash
from drivegate_cases.drive.drive_document import DriveDocument, load_drive


def made_outcome(check: str, verdict: str, **changes: Any) -> CheckSection:
    """Make the outcome of a check."""
    usual: dict[str, Any] = {
        "requirement": "The requirement.",
        "source": "P6",
        "subject": "candidate",
        "level": "required",
        "limit": "the limit",
        "margin": None,
        "measured": "measured",
        "runs": 1,
        "message": "as measured",
        "scenario": None,
        "counterexample": None,
    }
    return CheckSection.model_construct(id=check, verdict=verdict, **usual | changes)


def made_result(
    candidate: Candidate,
    drive: DriveDocument | None = None,
    *,
    faults: Iterable[Fault] = (),
    **changes: Any,
) -> ResultDocument:
    """Make the result of a check."""
    usual: dict[str, Any] = {
        "kind": "check",
        "verdict": "pass",
        "exit_code": 0,
        "seed": 0,
        "effort": "quick",
        "checks": (),
        "runs": 1,
        "set_aside": 0,
        "provenance": {"drivegate": "0.1.0"},
        "timing": {"seconds": 1.0},
    }
    return ResultDocument.model_construct(
        candidate=CandidateSection.of(candidate),
        drive=DriveSection.of(drive or load_drive("paper-5-phase"), None),
        faults=tuple(map(FaultSection.of, faults)),
        **usual | changes,
    )


def with_hash(document: dict[str, Any]) -> dict[str, Any]:
    """Return a result as drivegate writes it, with the hash of its content."""
    provenance = {"drivegate": "0.1.0", **document.get("provenance", {})}
    document = {**document, "provenance": provenance}
    return document | {"provenance": provenance | {"content_hash": content_hash(document)}}
