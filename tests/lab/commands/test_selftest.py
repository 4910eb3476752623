"""The command that checks the checks."""

from dataclasses import replace

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.gate.shard import DrawnRuns
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.commands import selftest
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest import subjects, unfair
from drivegate_lab.selftest.drawn import run
from drivegate_lab.selftest.drawn.tasks import GateRow
from drivegate_lab.selftest.unfair import Failure, GoodShard, ShardFailures


def test_a_fault_is_caught_by_its_check(command) -> None:
    ended = command("selftest", "--effort", "quick", "--fault", "advance-below-base", "--json")
    assert ended.code == 0, ended.out
    document = ended.document
    assert (document["schema"], document["kind"], document["passed"]) == (1, "selftest", True)
    (fault,) = document["faults"]
    assert (fault["name"], fault["named_check"], fault["caught"]) == ("advance-below-base", "ADV-1", True)
    assert fault["runs_to_first"] >= 1
    assert document["designs"] == [], "a chosen fault needs no correct designs"
    assert "faulty controllers: 1 of 1, advance-below-base: caught by ADV-1" in ended.err


def test_several_faults_are_shown_in_a_matrix(command) -> None:
    ended = command(
        "selftest", "--effort", "quick", "--workers", "2", "--fault", "drifts", "--fault", "faulty:slow-step"
    )
    assert ended.code == 0, ended.out
    assert "2 of 2 faults caught" in ended.out
    rows = {line.split()[0]: line for line in ended.out.splitlines() if "●" in line}
    assert {"drifts", "slow-step"} <= set(rows), ended.out


def test_a_fault_that_its_check_misses_ends_with_1(command, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = replace(MUTATIONS["flowchart-inverted"], check="TIM-1")
    monkeypatch.setattr(subjects, "FAULTS_OF", {"current": {**MUTATIONS, wrong.name: wrong}, "duty": {}})
    ended = command("selftest", "--effort", "quick", "--fault", wrong.name)
    assert ended.code == 1
    assert "TIM-1 misses the fault 'flowchart-inverted' with seed 0" in ended.out
    assert "0 of 1 faults caught" in ended.out


def test_an_unknown_fault_is_refused_with_the_nearest(refused) -> None:
    message = refused("selftest", "--fault", "drift")
    assert "'drift' is unknown, the nearest known one is 'drifts'" in message


def test_the_reference_and_a_fault_are_tried_on_a_drawn_drive(command, monkeypatch, tmp_path) -> None:
    # The whole check of the reference would take a minute; that of the fault ends with the first counterexample.
    monkeypatch.setattr(run, "run_gate", lambda *_: [GateRow(0, "pass", True, 40)])
    ended = command("selftest", "--drives", "1", "--workers", "1", "--fault", "advance-below-base", "--json")
    assert ended.code == 0, ended.err
    document = ended.document
    assert (document["kind"], document["effort"], document["drives"][0]["number"]) == (
        "selftest-drives",
        "quick",
        1,
    )
    (fault,) = document["faults"]
    assert (fault["count"], fault["of"]) == (1, 1), "a drive of another size hides no angle below base speed"
    assert load_drive(tmp_path / document["drives"][0]["file"]).name == document["drives"][0]["name"]


def test_the_kinds_of_drives_that_can_be_drawn_are_those_of_the_option() -> None:
    assert tuple(DRAWN_KINDS) == selftest.DRAWN


@pytest.mark.parametrize(
    ("words", "stated"),
    [
        (("--output", "somewhere"), "--output goes with --drives N only"),
        (("--faults",), "--faults goes with --drives N only"),
        (("--kind", "pm-ac"), "--kind goes with --drives N only"),
        (("--drives", "1", "--kind", "pm-ac", "--fault", "drifts"), "answers with a current reference"),
        (("--drives", "1", "--kind", "hub"), "'hub' is not one of 'half-bridge', 'star', 'pm-ac'"),
        (("--drawing-seed", "0"), "--drawing-seed goes with --drives N only"),
        (("--drives", "1", "--drive", "paper-5-phase"), "--drive does not go with --drives"),
        (("--drives", "1", "--drawn-only"), "--drawn-only does not go with --drives"),
        (("--drives", "1", "--faults", "--fault", "drifts"), "--fault does not go with --faults"),
        (("--drives", "1", "--unfair", "--faults"), "--faults does not go with --unfair"),
        (("--unfair", "--rare"), "--rare does not go with --unfair"),
    ],
)
def test_options_that_do_not_fit_are_refused(words, stated, refused) -> None:
    assert stated in refused("selftest", *words)


def test_unfair_scenarios_are_kept_until_the_next_search(command, monkeypatch, tmp_path) -> None:
    drive = load_drive("paper-5-phase")
    scenario = fixed_scenarios(drive)[0].to_mapping()
    failures = (Failure("reference", "CNV-1", Margin("CNV-1", -0.4, "slow"), scenario, is_unfair=True),)
    folder = tmp_path / "kept"
    searched = ("selftest", "--unfair", "--output", folder)
    monkeypatch.setattr(unfair, "_searched", lambda *_: [ShardFailures(3, failures)])
    monkeypatch.setattr(
        unfair,
        "good_shards",
        lambda _: [GoodShard(resolve_candidate("reference"), DrawnRuns(drive, 0, 4), 5)],
    )
    ended = command(*searched)
    assert ended.code == 1, ended.out
    kept = folder / "unfair-001-CNV-1.json"
    assert load_scenario(str(kept)).to_mapping() == scenario
    assert f"next: drivegate simulate reference --case {kept}" in " ".join(ended.out.split()), ended.out
    monkeypatch.setattr(unfair, "_searched", lambda *_: [ShardFailures(3, ())])
    ended = command(*searched)
    assert ended.code == 0, ended.out
    assert "next: --seeds N" in ended.out
    assert not kept.exists(), "what an earlier search found is no result of this one"


def test_a_folder_for_unfair_scenarios_is_refused_before_the_search(refused, monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(unfair, "unfair_document", lambda *_: pytest.fail("it searched"))
    place = tmp_path / "a file"
    place.write_text("", encoding="utf-8")
    assert "is a file; name a folder" in refused("selftest", "--unfair", "--output", place)


def test_faults_of_duty_ratios_are_tried_on_a_drive_that_takes_them(command, refused, tmp_path) -> None:
    drive = tmp_path / "brief.json"
    drive.write_text(load_drive("pm-ac-surface").replaced(settling_s=0.3).to_json(), encoding="utf-8")
    faults = ("--fault", "swapped-phases", "--fault", "saliency-ignored")
    ended = command("selftest", "--effort", "quick", "--drive", drive, *faults, "--json")
    assert ended.code == 0, ended.out
    swapped, ignored = ended.document["faults"]
    assert (swapped["named_check"], swapped["caught"], swapped["runs_to_first"]) == ("ACC-1", True, 1)
    assert ignored["does_not_apply"] == "the wrong value that the controller gets is right for this drive"
    assert ended.document["checks"][:2] == ["PWR-1", "DUT-1"], "the checks are those of the contract"
    assert "answers with duty ratios" in refused("selftest", "--fault", "swapped-phases")


def test_a_drive_that_there_is_not_is_refused(refused) -> None:
    assert "the nearest is 'paper-5-phase'" in refused(
        "selftest", "--fault", "angle-capped", "--drive", "paper-5-fase"
    )
    assert "missing.toml does not exist" in refused(
        "selftest", "--fault", "angle-capped", "--drive", "missing.toml"
    )
