"""The part of a check that one job does inside a worker process: run scenarios, judge them, search for worse."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.checks.check import Check, InfeasibleScenario, JudgedRun, NotRun, ShardOutcome, judged
from drivegate.checks.margin import Margin
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import applicable_checks, checks_of, contract_of
from drivegate.contracts.parting import empty_commands
from drivegate.drives.running import recorded, with_repetitions
from drivegate.scenarios.rotation import needs_reverse
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

SAFE: Final = 0.95
_ASKED: Final = 20
"""Scenarios that a search may ask for over those that it may run, since some show nothing new or are unfair."""
_LOOKED_AT: Final = 100


@dataclass(frozen=True)
class FixedRuns:
    """Scenarios to be run as they are."""

    scenarios: tuple[Scenario, ...]
    repeat: bool = False
    """Whether the first of them is run again afterwards, on the same instance and on a new one."""
    only_fair: bool = False
    """Whether those that no controller could do on their drive are set aside."""
    only: tuple[str, ...] = ()
    """Checks that are judged; empty for all. Scenarios that are not repeated are left out where none of them
    looks."""


@dataclass(frozen=True)
class DrawnRuns:
    """A shard of the search."""

    drive: DriveDocument
    seed: int
    """Seed of this shard; shards of consecutive seeds take turns at the families of scenarios."""
    examples: int
    """Number of scenarios to run at most."""
    search: bool = True
    """Whether to step toward small margins; if not, scenarios are drawn evenly throughout."""
    only: tuple[str, ...] = ()
    """Checks that are judged; empty for all. The shard is left out where none of them judges what it draws, and its
    last run where none looks at that."""


def content_key(scenario: Mapping[str, Any]) -> str:
    """Write what a scenario does, so that equal runs give the same text, whatever they are called."""
    content = {key: value for key, value in scenario.items() if key not in ("name", "description")}
    return json.dumps(content, sort_keys=True)


def run_fixed(loaded: JudgedCandidate, plan: FixedRuns) -> ShardOutcome:
    scenarios, infeasible = _fair(plan, loaded.candidate.declaration)
    if not plan.repeat:
        declaration = loaded.candidate.declaration
        scenarios = tuple(one for one in scenarios if is_needed(one, declaration, plan.only))
    if not scenarios:
        return ShardOutcome((), infeasible)
    controller = loaded.controller()
    kept = empty_commands(scenarios[0]) if plan.repeat else None
    first = recorded(loaded, scenarios[0], controller, kept=kept)
    records = [first, *(recorded(loaded, scenario, controller) for scenario in scenarios[1:])]
    # After all other runs on the same instance, so that what any of them leaves behind can show.
    if kept is not None:
        records[0] = with_repetitions(loaded, first, kept, controller)
    declaration = loaded.candidate.declaration
    runs = tuple(judged(record, checks_of(record.scenario.drive, declaration)) for record in records)
    return ShardOutcome(runs, infeasible)


def _fair(
    plan: FixedRuns, declaration: Declaration
) -> tuple[tuple[Scenario, ...], tuple[InfeasibleScenario, ...]]:
    """Part scenarios that a candidate may be judged on from those that no controller, or not this one, could do."""
    reasons = [(scenario, _unfair_because(scenario, plan, declaration)) for scenario in plan.scenarios]
    unfair = (InfeasibleScenario(scenario.name, why) for scenario, why in reasons if why is not None)
    return tuple(scenario for scenario, why in reasons if why is None), tuple(unfair)


def _unfair_because(scenario: Scenario, plan: FixedRuns, declaration: Declaration) -> str | None:
    if not declaration.reverses and needs_reverse(scenario):
        return "it needs a shaft that turns both ways, but the candidate's manifest states 'reverses = false'"
    return contract_of(scenario.drive).unfair_because(scenario) if plan.only_fair else None


def searched_checks(checks: Iterable[Check]) -> frozenset[str]:
    """Return the required ones of some checks whose margins do not depend on the machine, without the plant's."""
    return frozenset(
        check.id
        for check in checks
        if check.level == "required" and check.subject == "candidate" and not check.volatile
    )


@lru_cache(maxsize=4)
def _fixed_keys(drive: DriveDocument, declaration: Declaration) -> frozenset[str]:
    """Return the keys of the fixed runs; making them takes as long as a run, and a worker has several shards."""
    fixed = contract_of(drive).fixed_scenarios(drive, declaration)
    return frozenset(content_key(scenario.to_mapping()) for scenario in fixed)


class _Collector:
    """Runs the scenarios that a search asks for, and keeps what comes of them."""

    def __init__(self, loaded: JudgedCandidate, plan: DrawnRuns) -> None:
        drive = plan.drive
        self._loaded = loaded
        self._controller = loaded.controller()
        self._examples = plan.examples
        self._only = plan.only
        # A search that finds nothing new any more has ended too.
        self._asked = _ASKED * plan.examples
        self.contract = contract_of(drive)
        self.checks = checks_of(drive, loaded.candidate.declaration)
        self.searched = searched_checks(applicable_checks(drive, loaded.candidate.declaration))
        self._known = set(_fixed_keys(drive, replace(loaded.candidate.declaration, requirements=None)))
        self.fault: CandidateFault | None = None
        self.runs: list[JudgedRun] = []
        self.infeasible: list[InfeasibleScenario] = []

    @property
    def is_finished(self) -> bool:
        return self.fault is not None or len(self.runs) >= self._examples or self._asked <= 0

    def margins(self, scenario: Scenario) -> tuple[Margin, ...] | None:
        """Run a scenario; None where that would show nothing new."""
        self._asked -= 1
        key = content_key(scenario.to_mapping())
        if key in self._known:
            return None
        self._known.add(key)
        if (reason := self.contract.unfair_because(scenario)) is not None:
            self.infeasible.append(InfeasibleScenario(scenario.name, reason))
            return None
        if len(self.runs) == self._examples - 1 and not is_needed(
            scenario, self._loaded.candidate.declaration, self._only
        ):
            # No later scenario depends on the last run of a shard.
            self._asked = 0
            return None
        try:
            record = recorded(self._loaded, scenario, self._controller)
        except CandidateFault as fault:
            self.fault = fault
            return None
        outcome = judged(record, self.checks)
        self.runs.append(outcome)
        return outcome.margins


def run_drawn(loaded: JudgedCandidate, plan: DrawnRuns) -> ShardOutcome:
    """Draw scenarios, and step toward the limits of all checks, so that all of them see the same runs."""
    from hypothesis import given, seed
    from hypothesis.errors import Unsatisfiable

    from drivegate.gate.steps import Search
    from drivegate.scenarios.choices import ChoiceSource, Enough, draw_from

    declaration = loaded.candidate.declaration
    drawn = contract_of(plan.drive).drawn_scenarios(plan.drive, declaration, plan.seed)
    if plan.only and not _draws_needed(plan, drawn, declaration):
        return ShardOutcome(())
    collector = _Collector(loaded, plan)
    search = Search(plan.seed)
    source = ChoiceSource(plan.seed, search.choices if plan.search else tuple)

    @seed(plan.seed)
    @given(drawn)
    def explore(scenario: Scenario) -> None:
        # Hypothesis makes the first scenario without its backend.
        if not source.is_asked:
            return
        margins = collector.margins(scenario)
        search.judged(source.made, None if margins is None else _scores(margins, collector.searched))
        if collector.is_finished:
            raise Enough

    with suppress(Enough, Unsatisfiable):
        draw_from(source, explore, 2 * _ASKED * plan.examples)
    if collector.fault is not None:
        raise collector.fault
    return ShardOutcome(tuple(collector.runs), tuple(collector.infeasible))


def _draws_needed(plan: DrawnRuns, drawn: SearchStrategy[Scenario], declaration: Declaration) -> bool:
    """Return True if one of many scenarios that a shard could draw is needed."""
    from hypothesis import HealthCheck, Phase, find, settings
    from hypothesis.errors import NoSuchExample

    from drivegate.scenarios.isolation import from_the_seed_alone

    looked_at = settings(
        max_examples=max(_LOOKED_AT, plan.examples),
        database=None,
        deadline=None,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    with from_the_seed_alone(), suppress(NoSuchExample):
        find(
            drawn,
            lambda scenario: is_needed(scenario, declaration, plan.only),
            settings=looked_at,
            random=Random(plan.seed),
        )
        return True
    return False


def _scores(margins: Iterable[Margin], searched: Collection[str]) -> dict[str, float]:
    """Return the required margins by check, without what is nowhere near its limit: steps lead nowhere from there."""
    return {
        margin.check: margin.value
        for margin in margins
        if margin.check in searched and not margin.advisory and margin.value < SAFE
    }


@dataclass(frozen=True)
class JointRuns:
    drive: DriveDocument
    seed: int
    """Seed of what the covering array leaves open."""
    part: int
    parts: int
    """Which part of them, from 0, and how many parts there are."""
    only: tuple[str, ...] = ()
    """Checks that are judged; empty for all."""


def run_joint(loaded: JudgedCandidate, plan: JointRuns) -> ShardOutcome:
    declaration = loaded.candidate.declaration
    scenarios = contract_of(plan.drive).joint_scenarios(
        plan.drive, declaration, plan.seed, plan.part, plan.parts
    )
    return run_fixed(loaded, FixedRuns(scenarios, only=plan.only))


def is_needed(scenario: Scenario, declaration: Declaration, only: Collection[str]) -> bool:
    """Return True if one of some checks may judge a run of a scenario; no names mean all checks.

    Each check is evaluated without a run. One that returns no margin without a look at the run returns none after it.
    """
    if not only:
        return True
    contract = contract_of(scenario.drive)
    record = contract.unseen(declaration, scenario)
    try:
        checks = checks_of(scenario.drive, declaration)
        return any(check.evaluate(record) is not None for check in checks if check.id in only)
    except NotRun:
        return True
