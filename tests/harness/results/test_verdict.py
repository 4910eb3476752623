"""Verdicts from margins: which runs decide, what depends on the machine, and the simplest failure of many."""

import math
from typing import Any

import pytest

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.gate.shrinking import Shrunk, simplest_failures, with_simplest
from drivegate.results.document import CheckSection
from drivegate.results.result import MOST_MARGINS
from drivegate.results.verdict import candidate_verdict, check_outcomes, machine_dependent
from drivegate.scenarios.simplification import size_of
from drivegate_cases.scenario.scenario import load_scenario

LOCK_UP = load_scenario("lock-up")
DRIVE = LOCK_UP.drive
PLAIN = LOCK_UP.to_mapping()


def run(name: str, *margins: Margin, **changes: Any) -> JudgedRun:
    return JudgedRun({**PLAIN, "name": name, **changes}, margins)


def judged(
    check: str, *runs: JudgedRun, complete: bool = True, declaration: Declaration | None = None
) -> CheckSection:
    outcomes = check_outcomes(
        runs, declaration or Declaration(estimates_power=True), DRIVE, complete=complete
    )
    assert [outcome.id for outcome in outcomes] == [one.id for one in CHECKS]
    return next(outcome for outcome in outcomes if outcome.id == check)


def test_the_worst_run_decides() -> None:
    outcome = judged("CNV-1", run("a", Margin("CNV-1", 0.5, "x")), run("b", Margin("CNV-1", -0.1, "y")))
    assert (outcome.verdict, outcome.margin, outcome.runs) == ("fail", -0.1, 2)
    assert outcome.message == "y; fails in 1 of 2 runs: b"
    assert outcome.scenario == outcome.counterexample == run("b").scenario


def test_a_margin_of_zero_is_met() -> None:
    assert judged("CNV-1", run("a", Margin("CNV-1", 0.0, "x"))).verdict == "pass"


def test_where_a_check_only_advises_it_is_reported_and_does_not_decide() -> None:
    light = run("light", Margin("CNV-2", -3.0, "x", advisory=True))
    outcome = judged("CNV-2", run("a", Margin("CNV-2", 0.2, "y")), light)
    assert (outcome.verdict, outcome.margin, outcome.runs) == ("pass", 0.2, 1)
    assert outcome.message.endswith("advisory: not met in 1 run beyond what is required")


def test_without_runs_a_check_does_not_apply_or_is_not_known() -> None:
    assert judged("CNV-1").verdict == "not applicable"
    assert judged("CNV-1", complete=False).verdict == "inconclusive"


def test_what_a_candidate_declares_decides_what_applies() -> None:
    outcome = judged("FLO-1", complete=False)
    assert outcome.verdict == "not applicable"
    assert "does not declare" in outcome.message
    profile = FlowchartProfile(1.0, 0.0, 0.001, 0.02, 0.1)
    margins = run("a", Margin("FLO-1", 1.0, "x"))
    assert judged("FLO-1", margins, declaration=Declaration(flowchart=profile)).verdict == "pass"


@pytest.mark.parametrize(("value", "verdict"), [(0.9, "pass"), (-0.9, "fail")])
def test_numbers_that_depend_on_the_machine_stay_out_of_the_outcome(value: float, verdict: str) -> None:
    timed = run("a", Margin("TIM-1", value, "12 µs", is_timed=True))
    outcome = judged("TIM-1", timed)
    assert outcome.verdict == verdict
    reported = (outcome.margin, outcome.measured, outcome.scenario, outcome.counterexample)
    assert reported == (None, "", None, None)
    assert "12" not in outcome.message
    assert machine_dependent([timed]) == {"TIM-1": {"margin": value, "measured": "12 µs"}}


def test_the_simplest_failure_becomes_the_counterexample() -> None:
    hard = run("hard", Margin("CNV-1", -9.0, "much"), scales={"resistance": 1.23, "inductance": 0.9})
    easy = run("easy", Margin("CNV-1", -0.1, "little"))
    met = run("met", Margin("CNV-1", 0.3, "fine"), duration_s=9.0)
    assert size_of(easy.scenario) < size_of(hard.scenario)
    outcome = judged("CNV-1", hard, easy, met)
    assert outcome.scenario == hard.scenario
    (failure,) = simplest_failures([outcome], [hard, easy, met])
    assert failure.run is easy
    assert failure.job("quick").payload.worst == -9.0, "no simpler one is worse than the check is reported"
    (kept,) = with_simplest([outcome], [failure], {"CNV-1": None})
    assert (kept.scenario, kept.counterexample) == (hard.scenario, easy.scenario)
    assert kept.found is not None
    assert (kept.found.margin, kept.found.runs) == (-0.1, 0)
    shrunk = Shrunk(met.scenario, Margin("CNV-1", -0.05, "less"), 7)
    (simpler,) = with_simplest([outcome], [failure], {"CNV-1": shrunk})
    assert simpler.counterexample == met.scenario
    assert simpler.found is not None
    assert (simpler.found.margin, simpler.found.size, simpler.found.runs) == (-0.05, size_of(met.scenario), 7)


def test_margins_go_from_the_least_to_the_greatest_whatever_the_order_of_the_runs() -> None:
    runs = [run(str(value), Margin("CNV-1", value, "x")) for value in (0.5, -0.25, 0.75)]
    assert judged("CNV-1", *runs).margins == (-0.25, 0.5, 0.75)
    many = [run(str(place), Margin("CNV-1", float(-place), "x")) for place in range(MOST_MARGINS + 200)]
    kept = judged("CNV-1", *many).margins
    assert len(kept) == MOST_MARGINS
    assert (kept[0], kept[-1]) == (-MOST_MARGINS - 199.0, 0.0)
    assert list(kept) == sorted(kept)


def test_what_is_met_or_not_the_candidates_is_not_made_simpler() -> None:
    failing = run("a", Margin("PWR-1", -1.0, "x"), Margin("CNV-1", 1.0, "y"), Margin("DET-1", -1.0, "z"))
    outcomes = check_outcomes([failing], Declaration(), DRIVE, complete=True)
    failures = simplest_failures(outcomes, [failing])
    assert [(failure.check, failure.shrinks()) for failure in failures] == [("DET-1", False)]
    assert candidate_verdict(outcomes, []) == ("harness fault", 3), (
        "a broken plant is no verdict on a candidate"
    )


def test_a_margin_that_is_no_number_is_not_met() -> None:
    assert judged("CNV-1", run("a", Margin("CNV-1", math.nan, "x"))).verdict == "fail"
