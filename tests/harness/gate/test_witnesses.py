"""Every accusation is backed by a controller that meets the requirement in the very same scenario."""

from __future__ import annotations

from datetime import date
from typing import Any

import pytest
from tests.harness.made import made_outcome

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.contract import Witness
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate import witness_runs
from drivegate.gate.witnesses import (
    MOST_SCENARIOS,
    Accusation,
    Acquittal,
    Defence,
    accusations,
    hear_witnesses,
    with_witnesses,
)
from drivegate.results.document import FoundSection, WitnessedSection
from drivegate.results.result import witness_in_words
from drivegate.results.verdict import candidate_verdict
from drivegate.results.waivers import Waiver, under_waivers
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import load_scenario

PAPER = load_drive("paper-5-phase")
LOCK_UP = load_scenario("lock-up").to_mapping()
SHRUNK = LOCK_UP | {"duration_s": 12.0}
MARGIN = Margin("CNV-1", -2.0, "speed error 15 rpm")
OUTCOME = made_outcome(
    "CNV-1",
    "fail",
    margin=-2.0,
    measured=MARGIN.measured,
    message="speed error 15 rpm; fails in 1 of 1 runs: lock-up",
    scenario=LOCK_UP,
    counterexample=SHRUNK,
    found=FoundSection(margin=-1.0, measured="speed error 10 rpm", size=3, runs=5),
)
RUNS = [JudgedRun(LOCK_UP, (MARGIN,))]
WITNESSED = WitnessedSection(name="reference", margin=0.62, measured="speed error 2 rpm", knows_plant=False)


def scenarios(accusation: Accusation) -> list[Any]:
    return [scenario for scenario, _ in accusation.failures]


def test_the_counterexample_is_heard_first_and_then_the_worst_run() -> None:
    (accusation,) = accusations([OUTCOME], RUNS, PAPER)
    assert scenarios(accusation) == [SHRUNK, LOCK_UP]
    assert accusation.failures[0][1].value == -1.0
    assert accusation.failures[1][1] is MARGIN


def test_no_more_than_a_few_scenarios_are_heard() -> None:
    others = [JudgedRun(LOCK_UP | {"seed": seed}, (MARGIN,)) for seed in range(9)]
    (accusation,) = accusations([OUTCOME], [*RUNS, *others], PAPER)
    assert len(accusation.failures) == MOST_SCENARIOS


@pytest.mark.parametrize(
    "changes",
    [
        {"id": "DET-1"},
        {"subject": "plant"},
        {"verdict": "waived"},
        {"verdict": "pass"},
        {"counterexample": {"kind": "script"}},
        {"counterexample": None},
    ],
)
def test_what_no_witness_can_speak_on_is_not_heard(changes: dict[str, Any]) -> None:
    assert not accusations([OUTCOME.model_copy(update=changes)], RUNS, PAPER)


def test_a_failure_stands_where_a_witness_meets_the_requirement() -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    (outcome,) = with_witnesses([OUTCOME], {"CNV-1": (accused, Defence(WITNESSED, 0))})
    assert outcome.verdict == "fail"
    assert outcome.witness == WITNESSED
    assert outcome.counterexample == SHRUNK
    assert outcome.message.endswith("; reference meets it there with margin +0.62")
    assert candidate_verdict([outcome], []) == ("fail", 1)


def test_the_counterexample_becomes_the_run_that_has_a_witness() -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    (outcome,) = with_witnesses([OUTCOME], {"CNV-1": (accused, Defence(WITNESSED, 1))})
    assert outcome.counterexample == LOCK_UP
    assert outcome.found is not None
    assert (outcome.found.margin, outcome.found.measured) == (-2.0, "speed error 15 rpm")


def test_what_no_witness_meets_is_contested_and_does_not_count() -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    acquittal = Acquittal(("reference", "informed"))
    (outcome,) = with_witnesses([OUTCOME], {"CNV-1": (accused, acquittal)})
    assert outcome.verdict == "contested"
    assert outcome.witness is None
    assert "none of reference, informed meets it there, so it does not count" in outcome.message
    assert candidate_verdict([outcome], []) == ("contested", 0)
    other = OUTCOME.model_copy(update={"id": "CNV-2"})
    assert candidate_verdict([outcome, other], []) == ("fail", 1), "another failure counts all the same"


def test_a_contested_failure_counts_where_the_user_wants_it_to() -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    acquittal = Acquittal(("reference",))
    (outcome,) = with_witnesses([OUTCOME], {"CNV-1": (accused, acquittal)}, counts=True)
    assert outcome.verdict == "fail"
    assert "--contested fail counts it" in outcome.message


@pytest.mark.parametrize("ending", [None, Fault(FaultKind.CRASH, "it ended", "step")])
def test_a_failure_whose_witnesses_were_not_heard_does_not_count(ending: Fault | None) -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    (outcome,) = with_witnesses([OUTCOME], {"CNV-1": (accused, ending)})
    assert outcome.verdict == "not yet witnessed"
    assert outcome.counterexample == SHRUNK, "it can be run again"
    assert (
        "the check ended before known good controllers were run there, so it does not count"
        in outcome.message
    )
    assert candidate_verdict([outcome], []) == ("not yet witnessed", 1)
    other = OUTCOME.model_copy(update={"id": "CNV-2", "verdict": "inconclusive"})
    assert candidate_verdict([other, outcome], []) == ("not yet witnessed", 1)
    (counted,) = with_witnesses([OUTCOME], {"CNV-1": (accused, ending)}, counts=True)
    assert counted.verdict == "fail"


def test_a_waiver_holds_for_what_is_not_witnessed_yet() -> None:
    (accused,) = accusations([OUTCOME], RUNS, PAPER)
    outcomes = with_witnesses([OUTCOME], {"CNV-1": (accused, None)})
    last, margin = date(2030, 1, 1), -3.0
    for day, least, verdict in (
        (last, margin, "waived"),
        (date(2030, 1, 2), margin, "not yet witnessed"),
        (last, -1.0, "not yet witnessed"),
    ):
        waiver = Waiver(
            check="CNV-1", candidate="mine", reason="later", owner="me", expires=last, margin=least
        )
        (outcome,) = under_waivers(outcomes, "mine", [waiver], day)
        assert outcome.verdict == verdict


def test_the_reference_meets_what_the_published_search_does_not_in_the_same_scenario() -> None:
    accused = own_candidate(resolve_candidate("published"))
    ending = hear_witnesses(accused, Accusation("CNV-1", ((LOCK_UP, MARGIN),)))
    assert isinstance(ending, Defence), "the published search locks up at an angle that the reference leaves"
    assert ending.witnessed.name == "reference"
    assert ending.witnessed.margin > 0.0
    assert not ending.witnessed.knows_plant
    assert ending.place == 0


def test_a_witness_that_fails_as_well_contests_the_accusation(monkeypatch: pytest.MonkeyPatch) -> None:
    poor = Witness("published", ("half-bridge",))
    monkeypatch.setattr(witness_runs, "witnesses_for", lambda _drive: (poor,))
    accused = own_candidate(resolve_candidate("reference"))
    ending = hear_witnesses(accused, Accusation("CNV-1", ((LOCK_UP, MARGIN),)))
    assert ending == Acquittal(("published",))


def test_the_informed_witness_meets_what_only_a_plant_that_is_known_allows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (informed,) = _informed(PAPER)
    monkeypatch.setattr(witness_runs, "witnesses_for", lambda _drive: (informed,))
    accused = own_candidate(resolve_candidate("published"))
    weaker = LOCK_UP | {"duration_s": 16.0, "scales": {"inductance": 1.2}}
    for check, scenario in (("CNV-1", LOCK_UP), ("CNV-2", LOCK_UP), ("ROB-1", weaker)):
        ending = hear_witnesses(accused, Accusation(check, ((scenario, MARGIN),)))
        assert isinstance(ending, Defence), check
        assert ending.witnessed.knows_plant
        assert witness_in_words(dict(ending.witnessed)).startswith(
            "informed, which knows more than its nameplate, meets it"
        )


def _informed(drive: DriveDocument) -> list[Witness]:
    return [witness for witness in witness_runs.witnesses_for(drive) if witness.made_for is not None]


def test_the_informed_witness_of_duty_ratios_weakens_and_brakes_as_required(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drive = load_drive("pm-ac-interior")
    (informed,) = _informed(drive)
    monkeypatch.setattr(witness_runs, "witnesses_for", lambda _drive: (informed,))
    accused = own_candidate(resolve_candidate("foc-mtpa"))
    fixed = contract_named("duty").fixed_scenarios(drive, accused.candidate.declaration)
    (weakened,) = [run for run in fixed if run.name == "6000rpm-torque-0-2.387-0Nm"]
    for check in ("ACC-1", "FWK-1", "FWK-3", "OVC-1", "OVC-2"):
        ending = hear_witnesses(accused, Accusation(check, ((weakened.to_mapping(), MARGIN),)))
        assert isinstance(ending, Defence), check
    silent = hear_witnesses(accused, Accusation("SAF-1", ((weakened.to_mapping(), MARGIN),)))
    assert silent == Acquittal(())


def test_who_leaves_no_voltage_free_is_a_witness_against_needless_weakening() -> None:
    drive = load_drive("pm-ac-interior")
    assert isinstance(drive, PmAcDocument)
    scenario = torque_scenario(drive, -5000.0, (1.0,)).to_mapping()
    ending = hear_witnesses(
        own_candidate(resolve_candidate("foc")), Accusation("FWK-2", ((scenario, MARGIN),))
    )
    assert isinstance(ending, Defence), "foc weakens no more than the voltage requires"
    assert ending.witnessed.measured.startswith("less than 10 % of the voltage is free"), ending


@pytest.mark.parametrize("kind", DRIVE_KINDS.values(), ids=lambda kind: kind.name)
def test_every_kind_of_drive_has_a_witness_that_knows_no_more_than_its_nameplate(kind: Any) -> None:
    heard = witness_runs.witnesses_for(load_drive(kind.default_drive))
    assert heard[0].candidate == contract_named(kind.contract).usual_candidate, (
        "its code is compiled in any case"
    )
    assert not heard[0].knows_plant
    assert len(heard) > 1
    for witness in heard:
        assert witness.made_for is not None or resolve_candidate(witness.candidate).contract == kind.contract
