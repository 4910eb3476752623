"""Which part of a check is made: some checks alone, up to the first failure, what failed last time first."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any, Final

from drivegate.checks.judging import JudgedRun
from drivegate.results.counterexample import Counterexample
from drivegate.results.result import CheckOutcome


@dataclass(frozen=True)
class Focus:
    """What a check is confined to; by default to nothing."""

    only: tuple[str, ...] = ()
    """Identifiers of the checks that are judged; empty for all."""
    stop_at_first: bool = False
    """Whether no more work is begun after the first failure that counts."""
    first: tuple[Counterexample, ...] = ()
    """Counterexamples that are run before everything else."""

    def judges(self, check: str) -> bool:
        """Tell whether a check is judged."""
        return not self.only or check in self.only

    def outcomes(self, outcomes: Iterable[CheckOutcome]) -> tuple[CheckOutcome, ...]:
        """Leave out the checks that are not judged; a plant that failed is always told."""
        return tuple(
            outcome
            for outcome in outcomes
            if self.judges(outcome.id) or (outcome.subject == "plant" and outcome.verdict == "fail")
        )

    def broken_by(self, runs: Iterable[JudgedRun], counting: Collection[str]) -> bool:
        """Tell whether a run breaks one of the counting checks that are judged."""
        return any(
            not margin.met and not margin.advisory and margin.check in counting and self.judges(margin.check)
            for run in runs
            for margin in run.margins
        )

    def document(self, *, stopped: bool) -> dict[str, Any] | None:
        """Write as plain data what a result is confined to; None where it is confined to nothing."""
        if not self.only and not stopped:
            return None
        return {"only": list(self.only), "stopped_at_first": stopped}


WHOLE: Final = Focus()
"""The whole check."""
