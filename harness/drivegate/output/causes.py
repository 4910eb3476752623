"""What the runs of failed checks show: an account of each, a cause that several share, and likely causes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from shlex import quote
from typing import Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.recorded_trace import recorded_trace
from drivegate.output.wording import drive_option

FEWEST_CHECKS: Final = 2
"""Failed checks from which on something counts as their common cause."""
_TO_BE_MET: Final = ("fail", "waiver expired")


def account_of(document: Mapping[str, Any], check: Mapping[str, Any]) -> tuple[str, ...]:
    """Describe the run that a result shows for a check; nothing where its signals were not recorded."""
    trace = recorded_trace(document, check)
    return () if trace is None else contract_of(trace.scenario.drive).account(trace)


@dataclass(frozen=True)
class Cause:
    """What the counterexamples of several checks show."""

    words: str
    """What it is, in one clause."""
    checks: tuple[str, ...]
    """The failed checks whose counterexample shows it, in the order of the catalogue."""

    def __str__(self) -> str:
        return f"{self.words}: in the counterexamples of {', '.join(self.checks)}"


def causes_of(document: Mapping[str, Any]) -> tuple[Cause, ...]:
    """Group the failed checks of a result by what their runs show, the largest group first."""
    groups: dict[str, list[str]] = {}
    for check in document["checks"]:
        trace = None if check["counterexample"] is None else recorded_trace(document, check)
        words = None if trace is None else contract_of(trace.scenario.drive).common_cause(trace)
        if words is not None:
            groups.setdefault(words, []).append(str(check["id"]))
    causes = [Cause(words, tuple(checks)) for words, checks in groups.items() if len(checks) >= FEWEST_CHECKS]
    return tuple(sorted(causes, key=lambda cause: -len(cause.checks)))


def likely_causes_of(document: Mapping[str, Any]) -> tuple[str, ...]:
    """Name the likely causes of the failed checks of a result, the likeliest first."""
    checks = document["checks"]
    failed = [check for check in checks if check["verdict"] in _TO_BE_MET]
    met = {str(check["id"]) for check in checks if check["verdict"] == "pass"}
    traces = (recorded_trace(document, check) for check in failed)
    drive = next((trace.scenario.drive for trace in traces if trace is not None), None)
    if drive is None:
        return ()
    settled = {str(check["id"]) for check in checks if check["verdict"] != "inconclusive"}
    declaration = _declaration_in(document)
    unjudged = {
        check.id
        for check in contract_of(drive).checks
        # What does not apply to the candidate cannot confirm anything.
        if check.id not in settled and check.reason_not_applicable(declaration, drive) is None
    }
    checked = f"drivegate check {quote(str(document['candidate']['specification']))}{drive_option(document)}"
    causes = contract_of(drive).likely_causes(
        failed, met, unjudged, lambda check: f"{checked} --only {check}"
    )
    return tuple(f"likely cause {place} of {len(causes)}: {words}" for place, words in enumerate(causes, 1))


def _declaration_in(document: Mapping[str, Any]) -> Declaration:
    """Read what the candidate declares, as far as checks apply by it."""
    stated = document["candidate"]["declaration"]
    known = {field.name: stated[field.name] for field in fields(Declaration) if field.name in stated}
    return Declaration(**known)


def first_to_mend(document: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Choose the failed required check to begin with: of a fault, of the largest cause, else the first one."""
    failed = [
        check
        for check in document["checks"]
        if check["counterexample"] is not None
        and check["level"] == "required"
        and check["verdict"] in _TO_BE_MET
    ]
    unsteady = [check for check in failed if check["id"] == "DET-1"]
    explained = [name for cause in causes_of(document) for name in cause.checks]
    common = [check for name in explained for check in failed if check["id"] == name]
    return next(iter([*unsteady, *common, *failed]), None)
