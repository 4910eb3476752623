"""Making a scenario that breaks a check as simple as it can be had, within a number of runs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Generic, TypeVar

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import check_of, contract_of
from drivegate.contracts.contract import Witness
from drivegate.contracts.parting import SEED_IN_RESET
from drivegate.drives.running import recorded
from drivegate.gate.plan import REPEATED
from drivegate.gate.shard import content_key
from drivegate.gate.witness_runs import UNWITNESSED, witness_that_meets, witnesses_on
from drivegate.results.document import CheckSection, FoundSection
from drivegate.results.verdict import considered
from drivegate.scenarios.rotation import needs_reverse
from drivegate.scenarios.simplification import Simplification, simplified, size_of
from drivegate.scenarios.title import titled
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario

FoundT = TypeVar("FoundT")

_ROUNDING: Final = 1e-9
"""Share of a margin by which rounding may make a simpler failure worse (1)."""
BUDGET: Final = {"quick": 15, "default": 40, "nightly": 200}
"""Runs that may be spent on making one counterexample simpler, by effort."""
_FURTHER: Final = 2
"""Further scenarios that are tried where no witness meets a check in the simplest one."""
_GONE: Final = f"run again, it did not fail: two runs of the same scenario differ; {SEED_IN_RESET}"


@dataclass(frozen=True)
class ShrinkPlan:
    scenario: Mapping[str, Any]
    """A scenario as plain data that breaks the check, or a script."""
    check: str
    budget: int = 60
    """Number of runs that may be spent."""
    worst: float | None = None
    """Least margin that the check is reported with, which no simpler scenario may fall below; that of the
    scenario itself where None."""
    others: tuple[Mapping[str, Any], ...] = ()
    """Further scenarios that break it, tried where no witness meets the check in the first."""


@dataclass(frozen=True)
class Shrunk:
    scenario: dict[str, Any]
    """The simplest scenario found that breaks the check, as plain data."""
    margin: Margin
    runs: int


def run_shrink(loaded: JudgedCandidate, plan: ShrinkPlan) -> Shrunk | None:
    """Make a scenario simpler for as long as it is as fair, and breaks the same check by no more than is reported.

    Where a witness meets the check in it, one has to in each simpler scenario too. The same plan gives the same answer.
    """
    if plan.scenario.get("kind") == "script":
        return None
    scenario = parse_document(plan.scenario, Scenario, "the scenario")
    trials = _Trials(loaded, plan, scenario)
    margin = trials.failure(scenario)
    if margin is None:
        return None
    scenario, margin = _witnessed(plan, trials, scenario, margin)
    trials.begin(scenario)
    trials.worst = margin.value if plan.worst is None else min(margin.value, plan.worst)
    simplest, found = simplest_of(scenario, margin, trials)
    if simplest is not scenario:
        simplest = titled(simplest)
    return Shrunk(simplest.to_mapping(), found, trials.runs)


def _witnessed(
    plan: ShrinkPlan, trials: _Trials, scenario: Scenario, margin: Margin
) -> tuple[Scenario, Margin]:
    """Choose the first of the scenarios that a witness meets, which would be shown instead; else the simplest one."""
    if not trials.has_witnesses or trials.witness_in(scenario) is not None:
        return scenario, margin
    for mapping in plan.others:
        other = parse_document(mapping, Scenario, "the scenario")
        failed = None if trials.spent else trials.failure(other)
        if failed is not None and trials.witness_in(other) is not None:
            return other, failed
    return scenario, margin


class Trials(ABC, Generic[FoundT]):
    """Runs that show whether a simpler scenario still fails, each scenario at most once."""

    def __init__(self, declaration: Declaration, start: Scenario, budget: int) -> None:
        self._declaration = declaration
        self._start = start
        self._budget = budget
        self._known: set[str] = set()
        self.runs = 0

    @property
    def spent(self) -> bool:
        """Whether no more run may be made."""
        return self.runs >= self._budget

    def failure(self, scenario: Scenario) -> FoundT | None:
        """Run a scenario, and return what is wrong; None if it is not what is looked for."""
        # Different simplifications often lead to the same scenario, and a run costs far more than its key.
        self._known.add(content_key(scenario.to_mapping()))
        self.runs += 1
        return self._found(scenario)

    @abstractmethod
    def _found(self, scenario: Scenario) -> FoundT | None:
        """Run a scenario that counts already."""

    def is_due(self, scenario: Scenario) -> bool:
        """Return True if a scenario was not run yet, is what the candidate declares, and is as fair as the first."""
        is_new = content_key(scenario.to_mapping()) not in self._known
        return is_new and _is_as_fair(scenario, self._start, self._declaration)


class _Trials(Trials[Margin]):
    """Runs of one check."""

    def __init__(self, loaded: JudgedCandidate, plan: ShrinkPlan, scenario: Scenario) -> None:
        super().__init__(loaded.candidate.declaration, scenario, plan.budget)
        self._loaded = loaded
        self._controller = loaded.controller()
        self._check = check_of(scenario.drive.contract, plan.check, self._declaration)
        self.has_witnesses = plan.check not in UNWITNESSED and bool(witnesses_on(plan.check, scenario.drive))
        self.worst = -math.inf
        self.witness: Witness | None = None
        """What meets the check in the first scenario, and may not be lost; None before it is known."""

    def begin(self, scenario: Scenario) -> None:
        """Set what every simpler scenario is compared with."""
        self._start = scenario
        self.witness = self.witness_in(scenario)

    def _found(self, scenario: Scenario) -> Margin | None:
        """Run a scenario, and return the margin if the check fails, and no worse than it is reported."""
        try:
            record = recorded(self._loaded, scenario, self._controller)
        except CandidateFault as ended:
            # A candidate that hangs would cost its whole deadline in each further run, so this ends the job.
            if ended.fault.kind is FaultKind.HANG:
                raise
            # Another failure than the one looked for.
            return None
        margin = self._check.evaluate(record)
        if (
            margin is None
            or margin.met
            or margin.advisory
            or margin.value < self.worst - _ROUNDING * abs(self.worst)
        ):
            return None
        if self.witness is not None and self.witness_in(scenario) is None:
            return None
        return margin

    def witness_in(self, scenario: Scenario) -> Witness | None:
        first = () if self.witness is None else (self.witness,)
        return witness_that_meets(self._check.id, scenario, self._declaration, first)


def _is_as_fair(scenario: Scenario, start: Scenario, declaration: Declaration) -> bool:
    """Return True if a simpler scenario is what a candidate declares, and as fair as the one that it came from."""
    lowest, highest = declaration.speed_range_rpm or (-math.inf, math.inf)
    declared = all(lowest <= speed <= highest for _, speed in scenario.speed_rpm) and (
        declaration.reverses or needs_reverse(start) or not needs_reverse(scenario)
    )
    return declared and contract_of(scenario.drive).is_as_fair(scenario, start)


def simplest_of(scenario: Scenario, found: FoundT, trials: Trials[FoundT]) -> tuple[Scenario, FoundT]:
    """Go through all simplifications until a whole round of them finds nothing more, or the budget is spent."""
    # What worked is tried again first, since it may work again: one change goes after the other. After a round that
    # found something all are tried again, since a key that could not go may go now that another one is gone.
    improved = True
    while improved and not trials.spent:
        improved = False
        for simplification in contract_of(scenario.drive).simplifications:
            simpler = _simpler(scenario, simplification, trials)
            while simpler is not None:
                improved = True
                scenario, found = simpler
                simpler = _simpler(scenario, simplification, trials)
    return scenario, found


def _simpler(
    scenario: Scenario, simplification: Simplification, trials: Trials[FoundT]
) -> tuple[Scenario, FoundT] | None:
    for fields in simplification(scenario):
        simpler = simplified(scenario, fields)
        if simpler is None or not trials.is_due(simpler):
            continue
        # Asked after fairness, which costs no run: a budget that is spent ends the search only where a run is due.
        if trials.spent:
            return None
        found = trials.failure(simpler)
        if found is not None:
            return simpler, found
    return None


@dataclass(frozen=True)
class FailedRun:
    """The simplest run that breaks a check of the candidate."""

    check: str
    margin: Margin
    run: JudgedRun
    worst: float | None = None
    """Least margin that the check is reported with."""
    others: tuple[Mapping[str, Any], ...] = ()
    """Further scenarios that break it, the simplest first."""

    def shrinks(self) -> bool:
        """Return True if it is worth while to look for a simpler one."""
        return self.check != REPEATED and self.run.scenario.get("kind") != "script"

    def job(self, effort: str) -> Job[Shrunk | None]:
        plan = ShrinkPlan(self.run.scenario, self.check, BUDGET[effort], self.worst, self.others)
        return Job(run_shrink, plan)


def simplest_failures(outcomes: Iterable[CheckSection], runs: Sequence[JudgedRun]) -> list[FailedRun]:
    """Choose for every failed check of the candidate the simplest scenario that breaks it."""
    failures = []
    for outcome in outcomes:
        if outcome.counterexample is not None and outcome.subject == "candidate":
            broken = [item for item in considered(outcome.id, runs) if not item[0].met]
            # Not the worst run: the budget is small, and this one has the least to lose. How bad the check is at worst
            # is stored next to it, as a bound for what shrinking may find.
            broken.sort(key=lambda item: size_of(item[1].scenario))
            (margin, run), *further = broken
            others = tuple(
                other.scenario for _, other in further[:_FURTHER] if other.scenario.get("kind") != "script"
            )
            failures.append(FailedRun(outcome.id, margin, run, outcome.margin, others))
    return failures


def with_simplest(
    outcomes: Iterable[CheckSection],
    failures: Iterable[FailedRun],
    shrunk: Mapping[str, Shrunk | Fault | None],
) -> tuple[CheckSection, ...]:
    failed = {failure.check: failure for failure in failures}
    return tuple(
        _with_simplest(outcome, failed[outcome.id], shrunk) if outcome.id in failed else outcome
        for outcome in outcomes
    )


def _with_simplest(
    outcome: CheckSection, failure: FailedRun, shrunk: Mapping[str, Shrunk | Fault | None]
) -> CheckSection:
    simpler = shrunk.get(failure.check)
    if isinstance(simpler, Shrunk):
        return shown_by(outcome, simpler.scenario, simpler.margin, simpler.runs)
    margin = failure.margin
    if simpler is None and failure.check in shrunk:
        margin = replace(margin, measured=f"{margin.measured}; {_GONE}")
    return shown_by(outcome, failure.run.scenario, margin)


def shown_by(
    outcome: CheckSection, scenario: Mapping[str, Any], margin: Margin, runs: int = 0
) -> CheckSection:
    found = FoundSection.model_construct(
        margin=margin.value, measured=margin.measured, size=size_of(scenario), runs=runs
    )
    return outcome.model_copy(update={"counterexample": dict(scenario), "found": found})
