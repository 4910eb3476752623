"""The part of a check that a user requests: some checks alone, up to the first failure, what failed last time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate
from drivegate.gate.focus import Focus, is_called, named_checks
from drivegate.output.result_file import RESULT_FILE, counterexamples
from drivegate.results.result import counted_levels
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.counterexample import Counterexample
    from drivegate_cases.requirements.file import OwnRequirements


@dataclass(frozen=True)
class Part:
    """What is requested of a check; by default the whole."""

    only: tuple[str, ...] = ()
    """Checks, families of checks or lists of them with commas; empty for all."""
    stop_at_first: bool = False
    last_failed: bool = False
    """Whether only what failed in the last check is judged, its counterexamples first."""


WHOLE_CHECK: Final = Part()


def own_ids(candidates: Iterable[Candidate | None], stated: OwnRequirements | None) -> tuple[str, ...]:
    """List the identifiers of the user's rows: those of one file, or of all that manifests name."""
    named = [candidate.declaration.requirements for candidate in candidates if candidate is not None]
    files = [stated] if stated is not None else [own for own in named if own is not None]
    return tuple(dict.fromkeys(row.id for own in files for row in own.rows))


def focus_of(
    part: Part, candidates: Sequence[Candidate | None], output: Path, own: Sequence[str] = ()
) -> Focus:
    """Find the checks that are requested, and what failed in the last report of a folder."""
    from drivegate.contracts.catalogue import all_checks

    known = [*all_checks(), *own]
    named = _named(part.only, known)
    only = tuple(check for check in known if any(is_called(check, name) for name in named))
    first: tuple[Counterexample, ...] = ()
    if part.last_failed:
        if len(candidates) != 1 or candidates[0] is None:
            raise InputError("--last-failed takes one candidate, the one of the last report; name one")
        failed = _last_failed(output, candidates[0])
        first = tuple(stored for stored in failed if not only or stored.check in only)
        only = tuple(stored.check for stored in first) or only
    return Focus(only, named, part.stop_at_first, first)


def _named(words: Iterable[str], known: Sequence[str]) -> tuple[str, ...]:
    """Read names of checks and families, and refuse those that no contract has."""
    try:
        named = named_checks(words, known)
    except InputError as error:
        raise InputError(f"--only: {error}") from error
    if words and not named:
        raise InputError("--only names no check; name some, such as --only CNV-2,CNV-3")
    return named


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
    # Where advisory failures did not count, they are left out here too.
    counted = counted_levels(result.get("fail_on"))
    required = [check for check in result["checks"] if check["level"] in counted]
    stored = counterexamples({**result, "checks": required})
    return [
        parse_document(content, Counterexample, str(path))
        for content in stored
        if content["check"] not in waived
    ]
