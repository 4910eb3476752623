"""The part of a check that a user requests: some checks alone, up to the first failure, what failed last time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.gate.focus import Focus, is_called
from drivegate.output.result_file import RESULT_FILE, counterexamples
from drivegate.results.result import counted_levels
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.counterexample import Counterexample


@dataclass(frozen=True)
class Part:
    """What is requested of a check; by default the whole."""

    only: tuple[str, ...] = ()
    """Checks, families of checks or lists of them with commas; empty for all."""
    stop_at_first: bool = False
    """Whether to end with the first failure."""
    last_failed: bool = False
    """Whether only what failed in the last check is judged, its counterexamples first."""


WHOLE_CHECK: Final = Part()
"""The whole check."""


def focus_of(part: Part, candidates: Sequence[Candidate | None], output: Path) -> Focus:
    """Find the checks that are requested, and what failed in the last report of a folder."""
    named = _named(part.only)
    only = _chosen(named)
    first: tuple[Counterexample, ...] = ()
    if part.last_failed:
        if len(candidates) != 1 or candidates[0] is None:
            raise InputError("--last-failed takes one candidate, the one of the last report; name one")
        failed = _last_failed(output, candidates[0])
        first = tuple(stored for stored in failed if not only or stored.check in only)
        only = tuple(stored.check for stored in first) or only
    return Focus(only, named, part.stop_at_first, first)


def _named(words: Iterable[str]) -> tuple[str, ...]:
    """Read names of checks and families, and refuse those that no contract has."""
    from drivegate.contracts.catalogue import all_checks

    known = list(all_checks())
    named = tuple(word.strip().upper() for listed in words for word in listed.split(",") if word.strip())
    if words and not named:
        raise InputError("--only names no check; name some, such as --only CNV-2,CNV-3")
    for name in named:
        if not any(is_called(check, name) for check in known):
            raise InputError(
                f"--only: there is no check '{one_line(name)}', the nearest is '{nearest(name, known)}'; "
                "drivegate checks lists them"
            )
    return named


def _chosen(named: Iterable[str]) -> tuple[str, ...]:
    """Find the checks of any contract that are named, in the order of the catalogue."""
    from drivegate.contracts.catalogue import all_checks

    return tuple(check for check in all_checks() if any(is_called(check, name) for name in named))


def _last_failed(output: Path, candidate: Candidate) -> list[Counterexample]:
    """Read the counterexamples of the last report; those that are waived count as met."""
    from drivegate.output.result_reports import read_result
    from drivegate.results.counterexample import Counterexample
    from drivegate_cases.documents.document import parse_document

    path = output / RESULT_FILE
    if not path.is_file():
        raise InputError(
            f"--last-failed: there is no earlier result {shown_path(path)}; check once without --last-failed"
        )
    result = read_result(path)
    name = str(result["candidate"]["name"])
    if name != candidate.name:
        raise InputError(
            f"--last-failed: {shown_path(path)} is the result of '{one_line(name)}', not of "
            f"'{one_line(candidate.name)}'; name its folder with --output"
        )
    waived = {check["id"] for check in result["checks"] if check["verdict"] in ("contested", "waived")}
    stored: list[dict[str, Any]] = counterexamples(_required_alone(result))
    return [
        parse_document(content, Counterexample, str(path))
        for content in stored
        if content["check"] not in waived
    ]


def _required_alone(result: dict[str, Any]) -> dict[str, Any]:
    """Leave out checks that only advise, where these did not count."""
    counted = counted_levels(result.get("fail_on"))
    return {**result, "checks": [check for check in result["checks"] if check["level"] in counted]}
