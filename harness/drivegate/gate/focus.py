"""Which part of a check is made: some checks alone, up to the first failure, what failed last time first."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.checks.check import JudgedRun
    from drivegate.results.counterexample import Counterexample
    from drivegate.results.document import CheckSection


@dataclass(frozen=True)
class Focus:
    """What a check is confined to; by default to nothing."""

    only: tuple[str, ...] = ()
    """Identifiers of the checks that are judged; empty for all."""
    named: tuple[str, ...] = ()
    """Checks and families that the user named; each must be one of the drive's contract."""
    stop_at_first: bool = False
    """Whether no more work is begun after the first failure that counts."""
    first: tuple[Counterexample, ...] = ()
    """Counterexamples that are run before everything else."""

    def within(self, contract: str, own: Collection[str]) -> Focus:
        """Leave out the checks that a contract does not have; refuse a name that stands for none of its checks."""
        for name in self.named:
            if not any(is_called(check, name) for check in own):
                raise InputError(
                    f"--only: controllers of the contract '{contract}' are not judged by {name}, "
                    f"but by {', '.join(own)}"
                )
        return replace(self, only=tuple(check for check in self.only if check in own))

    def require_judged(self, outcomes: Iterable[CheckSection]) -> None:
        """Refuse to pass a candidate to which none of the named checks applies."""
        named = [outcome for outcome in outcomes if outcome.id in self.only]
        if named and all(outcome.verdict == "not applicable" for outcome in named):
            reasons = "; ".join(f"{outcome.id}: {outcome.message}" for outcome in named)
            raise InputError(
                f"--only: no named check applies, so nothing is judged ({reasons}); name others, or another drive with "
                "--drive"
            )

    def judges(self, check: str) -> bool:
        return not self.only or check in self.only

    def outcomes(self, outcomes: Iterable[CheckSection]) -> tuple[CheckSection, ...]:
        """Leave out the checks that are not judged; a plant that failed is always reported."""
        return tuple(
            outcome
            for outcome in outcomes
            if self.judges(outcome.id) or (outcome.subject == "plant" and outcome.verdict == "fail")
        )

    def broken_by(self, runs: Iterable[JudgedRun], counting: Collection[str]) -> bool:
        """Return True if a run breaks one of the counting checks that are judged."""
        return any(
            not margin.met and not margin.advisory and margin.check in counting and self.judges(margin.check)
            for run in runs
            for margin in run.margins
        )


WHOLE: Final = Focus()


def named_checks(words: Iterable[str], known: Sequence[str]) -> tuple[str, ...]:
    """Read names of checks and families, in capital letters, and refuse those that no contract has."""
    named = tuple(word.strip().upper() for listed in words for word in listed.split(",") if word.strip())
    for name in named:
        if not any(is_called(check, name) for check in known):
            raise InputError(
                f"there is no check '{one_line(name)}', the nearest is '{nearest(name, known)}'; drivegate checks "
                "lists them"
            )
    return named


def is_called(check: str, name: str) -> bool:
    """Return True if a name, in capital letters, is a check's identifier or its family's."""
    capital = check.upper()
    return name in (capital, capital.partition("-")[0])
