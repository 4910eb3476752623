"""The checks as tests in a user's own pytest suite: one item for each check, and one for the candidate.

pytest is imported where it is used, so that this module costs nothing outside of a test run.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any, Final, TypeVar

MARKER: Final = "drivegate_conformance"
"""Name of the pytest marker that the decorator sets."""
CANDIDATE_ITEM: Final = "candidate"
"""Id of the item that fails when the candidate was refused or had a fault."""

_Test = TypeVar("_Test")


class ConformanceWarning(UserWarning):
    """An advisory check is not met."""


def conformance_tests(
    candidate: str | None = None,
    *,
    drive: str | None = None,
    effort: str = "default",
    seed: int = 0,
    corpus: str | None = None,
    waivers: str | None = None,
) -> Callable[[_Test], _Test]:
    """Turn a test function into one item for each check of a candidate.

    The function takes the fixture `conformance` and calls its `verify`. The checks are made once in a session
    for each candidate, drive, effort and seed, by the generator that ``drivegate check`` uses, when the first item
    runs.

    Parameters
    ----------
    candidate : str, optional
        The candidate, as ``drivegate check`` takes it. The option ``--drivegate-candidate`` wins over it, and is
        needed without it.
    drive : str, optional
        The drive, as ``drivegate check --drive`` takes it; ``--drivegate-drive`` wins over it. Without it, the one that
        the candidate's manifest names, or the default.
    effort : {"default", "quick", "nightly"}
        Number of scenarios drawn; ``--drivegate-effort`` wins over it.
    seed : int
        Seed of the search, 0 or more; ``--drivegate-seed`` wins over it.
    corpus : str, optional
        Folder of counterexamples whose scenarios are run again.
    waivers : str, optional
        File of failures that are accepted.

    Returns
    -------
    callable
        The decorator. Paths in its arguments start from the folder of the test's file.

    Examples
    --------
    >>> from drivegate import conformance_tests
    >>> @conformance_tests("my_controller.py:Controller", effort="quick")
    ... def test_conformance(conformance):
    ...     conformance.verify()
    """
    import pytest

    mark = getattr(pytest.mark, MARKER)(
        candidate=candidate, drive=drive, effort=effort, seed=seed, corpus=corpus, waivers=waivers
    )

    def decorate(test: _Test) -> _Test:
        marked: _Test = mark(test)
        return marked

    return decorate


@dataclass(frozen=True)
class Judged:
    specification: str
    """The string that names it on the command line."""
    document: Mapping[str, Any] | None
    """The result document; None where there is no result."""
    folder: Path
    """Where the result and the counterexamples are."""
    refusal: str = ""
    """Why there is no result; empty where there is one."""


@dataclass(frozen=True)
class Conformance:
    """One item: a check of a candidate, or the candidate itself."""

    item: str
    """Identifier of the check, or ``candidate``."""
    judged: Judged

    @property
    def result(self) -> Mapping[str, Any] | None:
        """The result document, as ``drivegate check --json`` prints it; None where there is no result."""
        return self.judged.document

    @property
    def outcome(self) -> Mapping[str, Any] | None:
        """The part of the result document about this check; None for the candidate itself or without a result."""
        checks = () if self.judged.document is None else self.judged.document["checks"]
        return next((check for check in checks if check["id"] == self.item), None)

    def verify(self) -> None:
        """Pass, fail, skip or warn, as the check came out.

        A required check passes when it is met, and fails otherwise. A check that is waived is skipped with the owner
        and the last day of the waiver, and one that does not apply with the reason. An advisory check that is not met,
        and one whose failure is contested, is a `ConformanceWarning`. The item of the candidate fails when the
        candidate was refused, raised, crashed,
        hung or answered what is no answer.
        """
        import pytest

        __tracebackhide__ = True
        if self.item == CANDIDATE_ITEM:
            problem = self.judged.refusal or _faults(self.judged.document or {})
            if problem:
                pytest.fail(problem, pytrace=False)
            return
        outcome = self.outcome
        if outcome is None:
            pytest.fail(f"{self.item} was not judged, see [{CANDIDATE_ITEM}]", pytrace=False)
        elif outcome["verdict"] == "not applicable":
            pytest.skip(f"{self.item} is not applicable: {outcome['message']}")
        elif outcome["verdict"] == "waived":
            pytest.skip(f"{self.item} is waived: {outcome['message']}")
        elif outcome["verdict"] == "pass":
            return
        elif outcome["level"] == "required" and outcome["verdict"] != "contested":
            pytest.fail(self._message(outcome), pytrace=False)
        else:
            from drivegate.output.streams import harmless

            warnings.warn(harmless(self._message(outcome)), ConformanceWarning, stacklevel=2)

    def _message(self, outcome: Mapping[str, Any]) -> str:
        """State a check that is not met: what, by how much, and how to see it again."""
        from drivegate.checks.margin import margin_in_words
        from drivegate.output.explanations import explanations
        from drivegate.output.result_file import counterexample_name

        verdict = "fails" if outcome["verdict"] == "fail" else outcome["verdict"]
        explained = explanations(self.result or {"checks": (), "faults": ()}).get(self.item)
        message = "; ".join(filter(None, (explained, outcome["message"])))
        lines = [f"{self.item} {verdict} ({outcome['level']}): {message}"]
        lines.append(f"  required: {outcome['requirement']} Limit: {outcome['limit']}.")
        if outcome["subject"] == "plant":
            lines.append(
                "  this is a fault of drivegate itself, so no verdict on the candidate can be trusted"
            )
        if outcome["margin"] is not None:
            lines.append(f"  margin: {margin_in_words(outcome['margin'], 4)}")
        if outcome["counterexample"] is not None:
            file = self.judged.folder / counterexample_name(self.item)
            lines.append(f"  counterexample: {file}")
            lines.append(
                f"  replay: drivegate replay {quote(str(file))} --candidate {quote(self.judged.specification)}"
            )
        return "\n".join(lines)


def _faults(document: Mapping[str, Any]) -> str:
    from drivegate.output.explanations import distinct_faults, in_runs

    lines = []
    for fault, count in distinct_faults(document.get("faults", [])):
        lines.append(f"{fault['kind']}{in_runs(count)}: {fault['message']}")
        if fault["time_s"] is not None:
            lines.append(f"  in step {fault['step']}, at {fault['time_s']:g} s")
        lines += [f"  {line}" for line in fault["traceback"].splitlines()]
    return "\n".join(lines)
