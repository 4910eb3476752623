"""The search turned on the checks: what counts as unfair, what is kept of it, and what a witness excuses."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.gate.shard import DrawnRuns
from drivegate.gate.shrinking import Shrunk
from drivegate.gate.witnesses import Accusation, Acquittal, Defence
from drivegate.output.progress import Display
from drivegate.results.document import WitnessedSection
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest import unfair
from drivegate_lab.selftest.run import SelftestEffort
from drivegate_lab.selftest.unfair import GoodShard, ShardFailures, keep_unfair, run_good, unfair_document

DRIVE = load_drive("paper-5-phase")
SCENARIO = fixed_scenarios(DRIVE)[0].to_mapping()
REFERENCE = resolve_candidate("reference")
SHARD = GoodShard(REFERENCE, DrawnRuns(DRIVE, 0, 4), 5)
MET = Defence(WitnessedSection(name="witness", margin=0.5, measured="fine", knows_plant=False), 0)


def found(
    monkeypatch: pytest.MonkeyPatch, margins: dict[float, float], unmet_from_s: float, shrunk_s: float
) -> ShardFailures:
    """Search where runs of these durations (s) have these margins, and witnesses meet the check in shorter ones."""
    runs = tuple(
        JudgedRun({**SCENARIO, "duration_s": duration}, (Margin("CNV-1", margin, f"{margin:g}"),))
        for duration, margin in margins.items()
    )

    def heard(_: Any, accusation: Accusation) -> Acquittal | Defence:
        (scenario, _margin), *_others = accusation.failures
        return Acquittal(("witness",)) if scenario["duration_s"] >= unmet_from_s else MET

    shrunk = Shrunk({**SCENARIO, "duration_s": shrunk_s}, Margin("CNV-1", -0.1, "shrunk"), 3)
    monkeypatch.setattr(unfair, "run_drawn", lambda *_: ShardOutcome(runs))
    monkeypatch.setattr(unfair, "hear_witnesses", heard)
    monkeypatch.setattr(unfair, "run_shrink", lambda *_: shrunk)
    return run_good(own_candidate(REFERENCE), SHARD)


def test_a_failure_that_no_witness_avoids_is_unfair_and_shrunk(monkeypatch: pytest.MonkeyPatch) -> None:
    outcome = found(monkeypatch, {1.0: 0.5, 2.0: -0.2, 3.0: -0.4}, unmet_from_s=3.0, shrunk_s=3.5)
    (failure,) = outcome.failures
    assert (outcome.runs, failure.check, failure.is_unfair) == (3, "CNV-1", True)
    assert failure.scenario["duration_s"] == 3.5


def test_a_scenario_is_shrunk_only_to_one_that_no_witness_meets(monkeypatch: pytest.MonkeyPatch) -> None:
    (failure,) = found(monkeypatch, {3.0: -0.4}, unmet_from_s=3.0, shrunk_s=1.0).failures
    assert (failure.scenario["duration_s"], failure.margin.value) == (3.0, -0.4)


def test_a_failure_that_a_witness_avoids_is_of_the_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    (failure,) = found(monkeypatch, {1.0: -0.2}, unmet_from_s=9.0, shrunk_s=1.0).failures
    assert not failure.is_unfair
    assert found(monkeypatch, {1.0: 0.2}, unmet_from_s=0.0, shrunk_s=1.0).failures == ()


def test_a_check_that_does_not_apply_to_the_drive_accuses_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    started = resolve_candidate("foc-sensorless")
    runs = (JudgedRun(SCENARIO, (Margin("STA-1", -1.0, "it starts backward"),)),)
    monkeypatch.setattr(unfair, "run_drawn", lambda *_: ShardOutcome(runs))
    shard = GoodShard(started, DrawnRuns(load_drive("pm-ac-interior-sensorless"), 0, 4), 5)
    assert run_good(own_candidate(started), shard) == ShardFailures(1, ())


def document(monkeypatch: pytest.MonkeyPatch, outcome: ShardFailures) -> dict[str, Any]:
    monkeypatch.setattr(unfair, "_searched", lambda shards, _: [outcome] * len(shards))
    return unfair_document(SelftestEffort("quick", workers=1), Display())


def test_only_what_is_unfair_fails_the_checks_and_is_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    own = found(monkeypatch, {1.0: -0.2}, unmet_from_s=9.0, shrunk_s=1.0)
    passed = document(monkeypatch, own)
    assert passed["passed"]
    assert len(passed["met_by_a_witness"]) == 8 * len({shard.candidate.name for shard in shards()})
    assert keep_unfair(passed, tmp_path) == []
    unmet = found(monkeypatch, {3.0: -0.4}, unmet_from_s=3.0, shrunk_s=3.0)
    failed = document(monkeypatch, unmet)
    assert not failed["passed"]
    first, *_ = keep_unfair(failed, tmp_path)
    assert first == "unfair-001-CNV-1.json"
    assert json.loads((tmp_path / first).read_text(encoding="utf-8"))["duration_s"] == 3.0


def test_what_is_unfair_is_shown_as_it_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []
    monkeypatch.setattr(Display, "announce", lambda _, words: shown.append(words))
    document(monkeypatch, found(monkeypatch, {1.0: -0.2}, unmet_from_s=9.0, shrunk_s=1.0))
    assert shown == [], "a witness meets the check"
    unmet = document(monkeypatch, found(monkeypatch, {3.0: -0.4}, unmet_from_s=3.0, shrunk_s=3.0))
    assert len(shown) == len(unmet["unfair"]) == len(shards())
    assert shown[0] == "CNV-1 is met by no controller: reference on paper-5-phase, seed 0, shrunk"


@pytest.mark.nightly
def test_drawn_drives_are_searched_in_turn_and_summed_up(monkeypatch: pytest.MonkeyPatch) -> None:
    unmet = found(monkeypatch, {3.0: -0.4}, unmet_from_s=3.0, shrunk_s=3.0)
    monkeypatch.setattr(unfair, "_searched", lambda shards, _: [unmet] * len(shards))
    effort, drawn = (
        SelftestEffort("quick", workers=1),
        [DRAWN_KINDS["star"].draw(7, number) for number in (1, 2)],
    )
    both = unfair.unfair_on_drives(unfair.DrawnDrives("star", 2, 7), effort, Display())
    one = unfair_document(replace(effort, drive=drawn[0].document), Display())
    assert [drive["name"] for drive in both["drives"]] == [each.document.name for each in drawn]
    assert both["runs"] == 2 * one["runs"]
    assert both["unfair"][: len(one["unfair"])] == one["unfair"]
    assert {row["drive"] for row in both["unfair"]} == {each.document.name for each in drawn}
    assert not both["passed"]


def test_a_fault_of_a_correct_controller_is_no_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not document(monkeypatch, ShardFailures(0, (), "reference: it hangs"))["passed"]


def shards() -> list[GoodShard]:
    return unfair.good_shards(SelftestEffort("quick"))


def test_every_seed_and_correct_controller_has_its_shards() -> None:
    seeds = [
        (shard.candidate.name, shard.runs.seed) for shard in unfair.good_shards(SelftestEffort("quick", 2))
    ]
    assert len(set(seeds)) == len(seeds) == 2 * len(shards())
    assert {"reference", "golden-section"} <= {name.removeprefix("design:") for name, _ in seeds}
    assert not [name for name, _ in seeds if name.startswith("near:")]
