"""The part of a check that one job does inside a worker process: run scenarios, judge them, search for worse."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.checks.check import Check, InfeasibleScenario, JudgedRun, NotRun, ShardOutcome, judged
from drivegate.checks.margin import Margin
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import checks_of, contract_of
from drivegate.contracts.parting import room_for_commands
from drivegate.drives.running import recorded, with_repetitions
from drivegate.scenarios.rotation import needs_reverse
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

_GREATEST_SCORE: Final = 1e6
_SAFE: Final = 0.95
_TICKETS: Final = 2**48
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
    """Whether to climb toward small margins; if not, scenarios are drawn at random throughout."""
    only: tuple[str, ...] = ()
    """Checks that are judged; empty for all. The shard is left out where none of them judges what it draws.
    """


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
    kept = room_for_commands(scenarios[0]) if plan.repeat else None
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


class _Collector:
    """Runs what Hypothesis draws, and keeps what comes of it.

    Each draw has a ticket. Hypothesis likes to vary what it has drawn, and a variation keeps the ticket: so the
    first runs can be held to unrelated draws.
    """

    def __init__(self, loaded: JudgedCandidate, drive: DriveDocument, unrelated: int) -> None:
        self._loaded = loaded
        self._controller = loaded.controller()
        self._unrelated = unrelated
        self.contract = contract_of(drive)
        self.checks = checks_of(drive, loaded.candidate.declaration)
        self.searched = searched_checks(self.checks)
        fixed = self.contract.fixed_scenarios(drive, loaded.candidate.declaration)
        self._known = {content_key(scenario.to_mapping()) for scenario in fixed}
        self._tickets: set[int] = set()
        self._answers: dict[tuple[int, str], tuple[Margin, ...] | None] = {}
        self.fault: CandidateFault | None = None
        self._examples = 0
        self.runs: list[JudgedRun] = []
        self.infeasible: list[InfeasibleScenario] = []

    def margins(self, ticket: int, scenario: Scenario) -> tuple[Margin, ...] | None:
        """Run a scenario; None where that would show nothing new, the same for the same draw."""
        key = content_key(scenario.to_mapping())
        if (ticket, key) not in self._answers:
            self._answers[ticket, key] = self._new(ticket, key, scenario)
        answer = self._answers[ticket, key]
        self._examples += answer is not None
        return answer

    def _new(self, ticket: int, key: str, scenario: Scenario) -> tuple[Margin, ...] | None:
        varied = ticket in self._tickets
        self._tickets.add(ticket)
        if key in self._known or (varied and self._examples < self._unrelated):
            return None
        self._known.add(key)
        if (reason := self.contract.unfair_because(scenario)) is not None:
            self.infeasible.append(InfeasibleScenario(scenario.name, reason))
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
    """Draw scenarios, and climb toward the smallest margin of any check, so that all checks see the same runs."""
    from hypothesis import HealthCheck, Phase, assume, given, seed, settings, target
    from hypothesis.errors import Unsatisfiable
    from hypothesis.strategies import integers

    from drivegate.scenarios.isolation import from_the_seed_alone

    declaration = loaded.candidate.declaration
    drawn = contract_of(plan.drive).drawn_scenarios(plan.drive, declaration, plan.seed)
    if plan.only and not _draws_needed(plan, drawn, declaration):
        return ShardOutcome(())
    collector = _Collector(loaded, plan.drive, plan.examples // 2 if plan.search else plan.examples)

    @seed(plan.seed)
    @settings(
        max_examples=plan.examples,
        database=None,
        deadline=None,
        derandomize=False,
        phases=(Phase.generate, Phase.target) if plan.search else (Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(integers(0, _TICKETS), drawn)
    def explore(ticket: int, scenario: Scenario) -> None:
        # Hypothesis would run again what raises; a fault ends the search behind its back.
        margins = collector.margins(ticket, scenario) if collector.fault is None else ()
        # What shows nothing new does not count as an example.
        assume(margins is not None)
        for label, score in _scores(margins or (), collector.searched).items():
            target(score, label=label)

    with from_the_seed_alone(), suppress(Unsatisfiable):
        explore()
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
    """Return what the search climbs: by family of checks, such as CNV, the least required margin, upside down.

    What is nowhere near its limit is left out, or its small changes would be climbed as well.
    """
    scores: dict[str, float] = {}
    for margin in margins:
        if margin.check in searched and not margin.advisory and margin.value < _SAFE:
            family = margin.check.partition("-")[0]
            score = -max(min(margin.value, _GREATEST_SCORE), -_GREATEST_SCORE)
            scores[family] = max(scores.get(family, score), score)
    return scores


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
