"""One faulty controller before the check that must catch it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import CandidateFault
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import all_checks
from drivegate.gate.plan import REPEATED
from drivegate.gate.shard import DrawnRuns, FixedRuns, content_key, run_fixed
from drivegate.gate.shrinking import ShrinkPlan, run_shrink
from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.simplification import size_of
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario

_NOT_SHRUNK = frozenset({REPEATED, *(check.id for check in all_checks().values() if check.volatile)})


@dataclass(frozen=True)
class Trial:
    """What is to be tried."""

    candidate: Candidate
    """The faulty controller."""
    base: Candidate
    """The controller without the fault."""
    check: str
    """Identifier of the check that must catch it."""
    fixed: tuple[Job[ShardOutcome], ...]
    """Jobs that do not depend on the seed."""
    seeded: dict[int, tuple[Job[ShardOutcome], ...]]
    """Jobs that do, by seed."""
    budget: int
    """Number of runs that may be spent on making a counterexample simpler."""


@dataclass(frozen=True)
class Catch:
    """How a check caught a faulty controller."""

    runs: int
    """Number of runs up to the first counterexample, that one included."""
    scenario: str
    """Its name."""
    measured: str
    """What was measured in it."""
    size: int
    """Size of the counterexample that was made of it, as `drivegate.gate.shrinking.size_of` has it."""
    facts: tuple[str, ...]
    """What of that counterexample is not as in the plain run, as `drivegate.scenarios.facts.facts_of` has it.
    """


@dataclass(frozen=True)
class TrialOutcome:
    """What a trial came to."""

    catches: dict[int, Catch | None]
    """For each seed the catch, or None where the check missed the fault."""
    failing: tuple[str, ...]
    """Identifiers of all checks that failed in any run where the controller without the fault passes them."""
    runs: int
    """Number of runs made, without those that made a counterexample simpler."""
    faults: tuple[str, ...]
    """What the controller did beside the contract."""
    unconvincing: int
    """Number of failures of the named check that do not count, since the controller without the fault fails
    there too."""


def run_trial(_host: JudgedCandidate, trial: Trial) -> TrialOutcome:
    """Run a faulty controller until the named check catches it, with every seed.

    A failure counts where the controller without the fault passes. What the fixed scenarios show holds for every
    seed.
    """
    attempt = _Attempt(own_candidate(trial.candidate), own_candidate(trial.base), trial)
    caught = attempt.first(trial.fixed)
    catches: dict[int, Catch | None] = dict.fromkeys(trial.seeded, caught)
    if caught is None:
        before = attempt.runs
        for seed, jobs in trial.seeded.items():
            attempt.runs = before
            catches[seed] = attempt.first(jobs)
    failing = tuple(name for name in all_checks() if name in attempt.failing)
    return TrialOutcome(catches, failing, attempt.total, tuple(attempt.faults), attempt.unconvincing)


@dataclass
class _Attempt:
    """The runs of one trial."""

    faulty: JudgedCandidate
    base: JudgedCandidate
    trial: Trial
    runs: int = 0
    total: int = 0
    unconvincing: int = 0
    failing: set[str] = field(default_factory=set)
    faults: dict[str, None] = field(default_factory=dict)

    def first(self, jobs: Iterable[Job[ShardOutcome]]) -> Catch | None:
        """Do jobs until one has a counterexample."""
        for job in jobs:
            try:
                outcome = job.target(self.faulty, job.payload)
            except CandidateFault as raised:
                self.faults[raised.fault.message] = None
                continue
            caught = self._look_at(outcome.runs, job)
            if caught is not None:
                return caught
        return None

    def _look_at(self, runs: tuple[JudgedRun, ...], job: Job[ShardOutcome]) -> Catch | None:
        caught: Catch | None = None
        self.total += len(runs)
        for run in runs:
            self.runs += caught is None
            failed = _failed(run)
            excused = _failing_without_fault(self.base, run, job) if failed else frozenset()
            self.failing.update(check for check in failed if check not in excused)
            self.unconvincing += self.trial.check in failed and self.trial.check in excused
            if caught is None and self.trial.check in failed and self.trial.check not in excused:
                measured = failed[self.trial.check].measured
                simplest = self._simplest(run.scenario)
                name, facts = str(run.scenario["name"]), facts_of(simplest)
                caught = Catch(self.runs, name, measured, size_of(simplest), facts)
        return caught

    def _simplest(self, scenario: dict[str, Any]) -> dict[str, Any]:
        """Make a counterexample simpler, where that can be done."""
        if self.trial.check in _NOT_SHRUNK:
            return scenario
        shrunk = run_shrink(self.faulty, ShrinkPlan(scenario, self.trial.check, self.trial.budget))
        return scenario if shrunk is None else shrunk.scenario


def _failed(run: JudgedRun) -> dict[str, Margin]:
    """Return the margins that are not met, by check, without those that only advise."""
    return {margin.check: margin for margin in run.margins if not margin.met and not margin.advisory}


_known: dict[tuple[str, str, str], frozenset[str]] = {}
"""What controllers without a fault fail, by their name, kind of job and scenario; many faults share a base."""


def _failing_without_fault(base: JudgedCandidate, run: JudgedRun, job: Job[ShardOutcome]) -> frozenset[str]:
    """Return which checks the controller without the fault fails in a run of the same scenario."""
    key = (base.candidate.name, type(job.payload).__name__, content_key(run.scenario))
    if key not in _known:
        if isinstance(job.payload, DrawnRuns):
            scenario = parse_document(run.scenario, Scenario, "the scenario")
            again = run_fixed(base, FixedRuns((scenario,)))
        else:
            again = job.target(base, job.payload)
        _known[key] = frozenset(check for other in again.runs for check in _failed(other))
    return _known[key]
