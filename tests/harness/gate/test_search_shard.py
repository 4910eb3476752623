"""A shard of the search: every run is new and fair, the same seed gives the same runs, climbing can be left out."""

import subprocess
import sys
from collections.abc import Iterable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check, JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin
from drivegate.contracts.current.contract import CURRENT
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.gate.shard import DrawnRuns, FixedRuns, content_key, run_drawn, run_fixed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

DRIVE = load_drive("paper-5-phase")


class Loaded:
    """A built-in candidate in this very process."""

    def __init__(self, name: str = "reference") -> None:
        self.candidate: Candidate = resolve_candidate(name)

    def controller(self) -> Controller:
        return load_controller(self.candidate)


def drawn(seed: int, examples: int, **options: Any) -> ShardOutcome:
    return run_drawn(Loaded(), DrawnRuns(DRIVE, seed, examples, **options))  # type: ignore[arg-type]


@pytest.fixture
def judged_by_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a margin that falls with the distance from 1000 rpm in the place of runs and checks."""
    from drivegate.gate import shard as search_shard

    def judged(scenario: Scenario, _checks: Iterable[Check]) -> JudgedRun:
        margin = abs(scenario.speed_rpm[-1][1] - 1003.0) / 1000.0
        return JudgedRun(scenario.to_mapping(), (Margin("CNV-1", margin, "made up"),))

    monkeypatch.setattr(search_shard, "recorded", lambda _loaded, scenario, _controller: scenario)
    monkeypatch.setattr(search_shard, "judged", judged)


def contents(outcome: ShardOutcome) -> list[str]:
    return [content_key(run.scenario) for run in outcome.runs]


@pytest.mark.one_in(4)
@pytest.mark.usefixtures("judged_by_speed")
@pytest.mark.parametrize("seed", range(len(FAMILY_GROUPS)))
def test_no_run_is_made_twice_and_none_that_every_check_makes_anyway(seed: int) -> None:
    keys = contents(drawn(seed, 30))
    assert len(keys) == len(set(keys)), "a run was made twice"
    # Two ways to draw the same scenario are two examples, but one run.
    assert 18 <= len(keys) <= 30, "too many draws tell nothing new"
    fixed = {content_key(scenario.to_mapping()) for scenario in fixed_scenarios(DRIVE)}
    assert not fixed & set(keys)


@pytest.mark.usefixtures("judged_by_speed")
def test_the_seed_alone_decides() -> None:
    assert contents(drawn(4, 24)) == contents(drawn(4, 24))
    assert contents(drawn(4, 24)) != contents(drawn(4 + len(FAMILY_GROUPS), 24))


@pytest.mark.nightly
@pytest.mark.usefixtures("judged_by_speed")
def test_climbing_comes_closer_to_the_least_margin_than_drawing_at_random() -> None:
    def least(*, search: bool) -> float:
        outcomes = [drawn(8 * number, 40, search=search) for number in range(8)]
        return sum(min(run.margins[0].value for run in outcome.runs) for outcome in outcomes)

    climbed, random = least(search=True), least(search=False)
    assert climbed < 0.5 * random, f"the search comes to {climbed}, random scenarios to {random}"


@pytest.mark.usefixtures("judged_by_speed")
def test_what_no_angle_can_satisfy_is_counted_and_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(scenario: Scenario) -> str | None:
        return None if scenario.speed_rpm[0][1] > 1200.0 else "too slow"

    monkeypatch.setattr(type(CURRENT), "unfair_because", staticmethod(slow))
    outcome = drawn(0, 20)
    assert outcome.infeasible
    assert {drawn.reason for drawn in outcome.infeasible} == {"too slow"}
    assert all(drawn.scenario for drawn in outcome.infeasible), "an infeasible scenario has no name"
    assert all(run.scenario["speed_rpm"][0][1] > 1200.0 for run in outcome.runs)


@pytest.mark.usefixtures("judged_by_speed")
def test_a_shard_without_a_fair_scenario_is_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(CURRENT), "unfair_because", lambda _self, _scenario: "unfair")
    outcome = drawn(0, 3)
    assert not outcome.runs
    assert outcome.infeasible


@pytest.mark.usefixtures("judged_by_speed")
def test_a_declared_speed_range_holds_for_every_shard() -> None:
    loaded = Loaded()
    declared = Declaration(speed_range_rpm=(800.0, 900.0))
    loaded.candidate = replace(loaded.candidate, declaration=declared)
    for seed in range(len(FAMILY_GROUPS)):
        outcome = run_drawn(loaded, DrawnRuns(DRIVE, seed, 8))  # type: ignore[arg-type]
        speeds = {speed for run in outcome.runs for _, speed in run.scenario["speed_rpm"]}
        assert speeds
        assert all(800.0 <= speed <= 900.0 for speed in speeds), f"shard {seed} runs at {sorted(speeds)}"


def test_real_runs_carry_the_margins_of_the_checks() -> None:
    outcome = drawn(0, 2)
    assert len(outcome.runs) == 2
    for run in outcome.runs:
        assert {"PWR-1", "ADV-2", "CNV-2"} <= {margin.check for margin in run.margins}


@pytest.mark.usefixtures("judged_by_speed")
def test_fixed_scenarios_that_a_drive_cannot_do_are_set_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(scenario: Scenario) -> str | None:
        return None if scenario.speed_rpm[0][1] > 1200.0 else "too slow"

    monkeypatch.setattr(type(CURRENT), "unfair_because", staticmethod(slow))
    monkeypatch.setattr(
        "drivegate.gate.shard.recorded",
        lambda _loaded, scenario, _controller, kept=None: SimpleNamespace(scenario=scenario),
    )
    monkeypatch.setattr("drivegate.gate.shard.judged", _judged_as_it_is)
    slower, faster = fixed_scenarios(DRIVE)[2], fixed_scenarios(DRIVE)[7]
    outcome = run_fixed(Loaded(), FixedRuns((slower, faster), only_fair=True))  # type: ignore[arg-type]
    assert [run.scenario["name"] for run in outcome.runs] == [faster.name]
    assert [(aside.scenario, aside.reason) for aside in outcome.infeasible] == [(slower.name, "too slow")]
    nothing = run_fixed(Loaded(), FixedRuns((slower,), only_fair=True))  # type: ignore[arg-type]
    assert not nothing.runs


def _judged_as_it_is(record: Any, _checks: Iterable[Check]) -> JudgedRun:
    return JudgedRun(record.scenario.to_mapping(), ())


def test_planning_and_judging_do_without_hypothesis_which_is_for_drawing() -> None:
    program = "import sys, drivegate.gate.engine; sys.exit('hypothesis' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)
