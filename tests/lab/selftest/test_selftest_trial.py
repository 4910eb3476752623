"""A trial: how a fault is caught, when a failure counts, and what is left when none does."""

from types import SimpleNamespace
from typing import Any

import pytest

from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.selftest import trial as trial_module
from drivegate_lab.selftest.run import SelftestEffort, planned_trial
from drivegate_lab.selftest.trial import Trial, run_trial

SCENARIO = fixed_scenarios(load_drive("paper-5-phase"))[0].to_mapping()
FAULTY = resolve_candidate("faulty:drifts")
BASE = resolve_candidate("reference")
# It is not made simpler, so that no run is made here.
CHECK = "DET-1"


@pytest.fixture(autouse=True)
def nothing_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_module, "_known", {})


def loaded() -> JudgedCandidate:
    def load() -> Any:
        raise AssertionError("the host is not to be loaded")

    return JudgedCandidate(BASE, load)


def job(faulty: tuple[float, ...], base: tuple[float, ...] = (1.0,), check: str = CHECK) -> Job[ShardOutcome]:
    """Make a job with one run for each margin."""

    def target(candidate: JudgedCandidate, payload: Any) -> ShardOutcome:
        values = faulty if candidate.candidate.name == FAULTY.name else base
        return ShardOutcome(
            tuple(
                JudgedRun({**SCENARIO, "duration_s": 1.0 + index}, (Margin(check, value, f"{value:g}"),))
                for index, value in enumerate(values)
            )
        )

    return Job(target, None)


def tried(*fixed: Job[ShardOutcome], seeded: dict[int, tuple[Job[ShardOutcome], ...]] | None = None) -> Any:
    return run_trial(loaded(), Trial(FAULTY, BASE, CHECK, fixed, seeded or {0: ()}, 5))


def test_the_first_counterexample_is_counted_in_runs() -> None:
    outcome = tried(job((1.0, 0.5)), job((0.2, -0.5, -3.0)))
    catch = outcome.catches[0]
    assert (catch.runs, catch.measured) == (4, "-0.5")
    assert (outcome.runs, outcome.failing, outcome.unconvincing) == (5, (CHECK,), 0)


def test_a_catch_among_the_fixed_scenarios_holds_for_every_seed() -> None:
    never = job((), ())
    outcome = tried(job((-1.0,)), seeded={0: (never,), 1: (never,)})
    assert [catch.runs for catch in outcome.catches.values()] == [1, 1]
    assert outcome.runs == 1


def test_each_seed_counts_from_the_fixed_scenarios_on() -> None:
    outcome = tried(job((1.0, 1.0)), seeded={0: (job((1.0, -1.0)),), 1: (job((-1.0,)),), 2: (job((1.0,)),)})
    runs = [None if catch is None else catch.runs for catch in outcome.catches.values()]
    assert runs == [4, 3, None]


def test_a_failure_that_the_base_shares_does_not_count() -> None:
    outcome = tried(job((-1.0,), (-1.0,)))
    assert outcome.catches == {0: None}
    assert (outcome.failing, outcome.unconvincing) == ((), 1)


def test_another_check_that_fails_is_no_catch() -> None:
    outcome = tried(job((-1.0,), check="ADV-1"))
    assert outcome.catches == {0: None}
    assert outcome.failing == ("ADV-1",)


def test_a_fault_beside_the_contract_is_kept_and_the_trial_goes_on() -> None:
    def raising(candidate: JudgedCandidate, payload: Any) -> ShardOutcome:
        raise CandidateFault(Fault(FaultKind.INVALID_OUTPUT, "the command is not finite", "step"))

    outcome = tried(Job(raising, None), job((-1.0,)))
    assert outcome.catches[0].runs == 1
    assert outcome.faults == ("the command is not finite",)


@pytest.mark.parametrize("simplest", [{**SCENARIO, "control_period_s": 1e-4}, None])
def test_the_counterexample_is_made_simpler(
    monkeypatch: pytest.MonkeyPatch, simplest: dict[str, Any] | None
) -> None:
    found = None if simplest is None else SimpleNamespace(scenario=simplest)
    monkeypatch.setattr(trial_module, "run_shrink", lambda *_: found)
    work = job((-1.0,), check="CNV-1")
    outcome = run_trial(loaded(), Trial(FAULTY, BASE, "CNV-1", (work,), {0: ()}, 5))
    catch = outcome.catches[0]
    assert catch is not None
    left = {**SCENARIO, "duration_s": 1.0} if simplest is None else simplest
    assert (catch.size, catch.facts) == (trial_module.size_of(left), trial_module.facts_of(left))
    assert catch.scenario == SCENARIO["name"]


@pytest.mark.parametrize("fault", ["slope-doubled", "flowchart-inverted"])
def test_drawing_alone_has_to_do_without_the_fixed_scenarios(fault: str) -> None:
    known = MUTATIONS[fault]
    whole = planned_trial(known, SelftestEffort("quick", seeds=2))
    drawn = planned_trial(known, SelftestEffort("quick", seeds=2, drawn_only=True))
    assert drawn.fixed == ()
    assert [len(jobs) for jobs in drawn.seeded.values()] == [len(jobs) for jobs in whole.seeded.values()]
    assert all(drawn.seeded.values()), "something has to be left that can catch the fault"
