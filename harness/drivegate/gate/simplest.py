"""From the runs that break a check to one scenario, as simple as it can be had."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from drivegate.candidates.fault import Fault
from drivegate.checks.judging import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job
from drivegate.contracts.parting import SEED_IN_RESET
from drivegate.gate.plan import REPEATED
from drivegate.gate.shrinking import ShrinkPlan, Shrunk, run_shrink, size_of
from drivegate.results.result import CheckOutcome, Found
from drivegate.results.verdict import considered

BUDGET: Final = {"quick": 15, "default": 40, "nightly": 200}
"""Runs that may be spent on making one counterexample simpler, by effort."""
_GONE: Final = f"run again, it did not fail: two runs of the same scenario differ; {SEED_IN_RESET}"


@dataclass(frozen=True)
class FailedRun:
    """The simplest run that breaks a check of the candidate."""

    check: str
    """Identifier of the check."""
    margin: Margin
    """Its margin."""
    run: JudgedRun
    """The run."""
    worst: float | None = None
    """Least margin that the check is reported with."""

    def shrinks(self) -> bool:
        """Tell whether it is worth while to look for a simpler one."""
        return self.check != REPEATED and self.run.scenario.get("kind") != "script"

    def job(self, effort: str) -> Job[Shrunk | None]:
        """Plan the search for a simpler one."""
        return Job(run_shrink, ShrinkPlan(self.run.scenario, self.check, BUDGET[effort], self.worst))


def simplest_failures(outcomes: Iterable[CheckOutcome], runs: Sequence[JudgedRun]) -> list[FailedRun]:
    """Choose for every failed check of the candidate the simplest scenario that breaks it."""
    failures = []
    for outcome in outcomes:
        if outcome.counterexample is not None and outcome.subject == "candidate":
            broken = [item for item in considered(outcome.id, runs) if not item[0].met]
            margin, run = min(broken, key=lambda item: size_of(item[1].scenario))
            failures.append(FailedRun(outcome.id, margin, run, outcome.margin))
    return failures


def with_simplest(
    outcome: CheckOutcome,
    failures: Iterable[FailedRun],
    shrunk: Mapping[str, Shrunk | Fault | None],
) -> CheckOutcome:
    """Put the simplest counterexample that was found into an outcome."""
    failure = next((failure for failure in failures if failure.check == outcome.id), None)
    if failure is None:
        return outcome
    simpler = shrunk.get(failure.check)
    if isinstance(simpler, Shrunk):
        found = Found(simpler.margin.value, simpler.margin.measured, simpler.size, simpler.runs)
        return replace(outcome, counterexample=simpler.scenario, found=found)
    scenario, measured = failure.run.scenario, failure.margin.measured
    if simpler is None and failure.check in shrunk:
        measured = f"{measured}; {_GONE}"
    found = Found(failure.margin.value, measured, size_of(scenario), 0)
    return replace(outcome, counterexample=scenario, found=found)
