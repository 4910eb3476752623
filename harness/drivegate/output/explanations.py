"""What happened in a run, what failed checks have in common, and what kept others from a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.recorded_trace import recorded_trace, trace_of_run
from drivegate_cases.documents.wording import counted, one_line
from drivegate_cases.scenario.scenario import Scenario

FEWEST_CHECKS: Final = 2
"""Failed checks from which on something counts as their common cause."""
_TO_BE_MET: Final = ("fail", "waiver expired")
_NOT_JUDGED = "not judged"
_IN_PART = "judged in part only"


def account_of(document: Mapping[str, Any], check: Mapping[str, Any]) -> tuple[str, ...]:
    """Describe the run that a result shows for a check; nothing where its signals were not recorded."""
    trace = recorded_trace(document, check)
    return () if trace is None else contract_of(trace.scenario.drive).account(trace)


def account_of_run(scenario: Scenario, run: Any, judged_s: tuple[float, float]) -> tuple[str, ...]:
    """Describe a finished run."""
    trace = trace_of_run(scenario, run, judged_s)
    return () if trace is None else contract_of(scenario.drive).account(trace)


@dataclass(frozen=True)
class Cause:
    """What the counterexamples of several checks show."""

    words: str
    """What it is, in one clause."""
    checks: tuple[str, ...]
    """The failed checks whose counterexample shows it, in the order of the catalogue."""

    def __str__(self) -> str:
        """State the cause and its checks in one line."""
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
    failed = [check for check in document["checks"] if check["verdict"] in _TO_BE_MET]
    traces = (recorded_trace(document, check) for check in failed)
    drive = next((trace.scenario.drive for trace in traces if trace is not None), None)
    causes = () if drive is None else contract_of(drive).likely_causes(failed)
    return tuple(f"likely cause {place} of {len(causes)}: {words}" for place, words in enumerate(causes, 1))


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


def by_urgency(checks: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Order checks for reading: what fails first, what is met or does not apply last."""
    return sorted(checks, key=_urgency)


def _urgency(check: Mapping[str, Any]) -> int:
    if check["verdict"] in ("pass", "not applicable"):
        return 3
    if check["verdict"] == "contested":
        return -1
    if check["verdict"] in ("waived", "inconclusive"):
        return 2
    return 0 if check["level"] == "required" else 1


def unjudged_in_words(document: Mapping[str, Any]) -> str:
    """List the checks that a fault kept from being judged; nothing where there is none."""
    parts = []
    for how in (_NOT_JUDGED, _IN_PART):
        names = [str(check["id"]) for check in _unjudged(document) if _how_judged(check) == how]
        if names:
            parts.append(f"{how}: {', '.join(names)}")
    return "; ".join(parts)


def explanations(document: Mapping[str, Any]) -> dict[str, str]:
    """Return by check what explains its outcome, where something does."""
    explained: dict[str, str] = {}
    if any(check["counterexample"] is not None for check in document["checks"]):
        # It brings the oracle, which a result without failures does not need.

        for cause in causes_of(document):
            words = f"{cause.words} (common cause of {', '.join(cause.checks)})"
            explained |= dict.fromkeys(cause.checks, words)
    for check in _unjudged(document):
        explained[str(check["id"])] = f"{_how_judged(check)}, because of {_first_fault(document)}"
    return {check: one_line(words) for check, words in explained.items()}


def _first_fault(document: Mapping[str, Any]) -> str:
    """State the first fault, and how many there are beside it."""
    (fault, _), *others = distinct_faults(list(document["faults"]))
    more = f" and {counted(len(others), 'more fault')}" if others else ""
    return f"{fault['kind']}: {fault['message']}{more}"


def _unjudged(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Choose the checks that a fault of the candidate has left open."""
    if not document["faults"]:
        return []
    return [check for check in document["checks"] if check["verdict"] == "inconclusive"]


def _how_judged(check: Mapping[str, Any]) -> str:
    return _IN_PART if check["runs"] else _NOT_JUDGED


def distinct_faults(faults: list[dict[str, Any]]) -> list[tuple[dict[str, Any], int]]:
    """Group faults by what happened."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for fault in faults:
        groups.setdefault((fault["kind"], fault["phase"], fault["message"]), []).append(fault)
    return [(group[0], len(group)) for group in groups.values()]


def in_runs(count: int) -> str:
    """State how often a fault happened, where it was more than once."""
    return f" in {count} runs" if count > 1 else ""
