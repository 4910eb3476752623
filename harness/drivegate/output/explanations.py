"""The order of checks for reading, and what explains their outcomes: a common cause, or a fault."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from drivegate.results.result import NOT_WITNESSED
from drivegate_cases.documents.wording import counted, one_line

_NOT_JUDGED = "not judged"
_IN_PART = "judged in part only"


def by_urgency(checks: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Order checks for reading: what fails first, what is met or does not apply last, required before advisory."""
    return sorted(checks, key=_urgency)


_LATER: Final = ("contested", NOT_WITNESSED, "inconclusive", "waived", "pass", "not applicable")
"""Verdicts after those that fail, in their order."""


def _urgency(check: Mapping[str, Any]) -> tuple[int, bool]:
    verdict = check["verdict"]
    return 1 + _LATER.index(verdict) if verdict in _LATER else 0, check["level"] != "required"


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
        from drivegate.output.causes import causes_of

        for cause in causes_of(document):
            words = f"{cause.words} (common cause of {', '.join(cause.checks)})"
            explained |= dict.fromkeys(cause.checks, words)
    for check in _unjudged(document):
        (fault, _), *others = distinct_faults(list(document["faults"]))
        more = f" and {counted(len(others), 'more fault')}" if others else ""
        because = f"{fault['kind']}: {fault['message']}{more}"
        explained[str(check["id"])] = f"{_how_judged(check)}, because of {because}"
    return {check: one_line(words) for check, words in explained.items()}


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
