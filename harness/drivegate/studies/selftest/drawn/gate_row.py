"""What has become of the reference on one drawn drive, as it is kept in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from drivegate.results.result import CheckOutcome, CheckResult
from drivegate.scenarios.facts import facts_in_short


@dataclass(frozen=True)
class FailedCheck:
    """A required check that failed."""

    check: str
    """Its identifier."""
    margin: float | None
    """Its least margin."""
    measured: str
    """What was measured in the simplest counterexample."""
    limit: str
    """The limit."""
    facts: str
    """The facts of the simplest counterexample."""
    contested: bool = False
    """Whether no known good controller meets it either, so that it does not count against a candidate."""


@dataclass(frozen=True)
class GateRow:
    """The verdict on a candidate with one seed."""

    seed: int
    """Seed of the search."""
    verdict: str
    """As in `drivegate.results.result.CheckResult`, or ``refused`` where the drive cannot be judged on."""
    passed: bool
    """Whether the candidate passes."""
    runs: int = 0
    """Number of runs made."""
    failed: tuple[FailedCheck, ...] = ()
    """The required checks that failed."""
    message: str = ""
    """What ended the check otherwise, in one sentence; empty where nothing did."""

    def document(self) -> dict[str, Any]:
        """Write the row as plain data."""
        return asdict(self)


def gate_row(result: CheckResult) -> GateRow:
    """Take from a whole check what is kept of it."""
    return GateRow(
        seed=result.seed,
        verdict=result.verdict,
        passed=result.exit_code == 0 and result.verdict != "contested",
        runs=result.runs,
        failed=tuple(_failed(result.checks)),
        message=result.faults[0].message if result.faults else "",
    )


def row_from(document: Mapping[str, Any]) -> GateRow:
    """Read a row that was kept."""
    return GateRow(**{**document, "failed": tuple(FailedCheck(**check) for check in document["failed"])})


def _failed(outcomes: Sequence[CheckOutcome]) -> list[FailedCheck]:
    return [
        FailedCheck(
            check=outcome.id,
            margin=outcome.margin,
            measured=outcome.measured if outcome.found is None else outcome.found.measured,
            limit=outcome.limit,
            contested=outcome.verdict == "contested",
            facts="" if outcome.counterexample is None else facts_in_short(outcome.counterexample),
        )
        for outcome in outcomes
        if outcome.level == "required" and outcome.verdict in ("fail", "contested")
    ]
