"""A self-test on drawn drives goes on where it stopped, mixes nothing, and says what it found."""

import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivegate.output.console import console_for
from drivegate.output.progress import Display
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.selftest.drawn import run, tasks
from drivegate_lab.selftest.drawn.display import show_drives
from drivegate_lab.selftest.drawn.run import DrivesRequest, selftest_on_drives
from drivegate_lab.selftest.drawn.tasks import FailedCheck, GateRow, row_from
from drivegate_lab.selftest.matrix import FaultRow
from drivegate_lab.selftest.run import SelftestEffort
from drivegate_models.errors import HarnessFault, InputError

FAULT = "slope-doubled"
FAILED = FailedCheck("CNV-1", -0.5, "moves by 3°", "1°", "at 900 rpm")
WORSE = replace(FAILED, margin=-0.7, measured="moves by 4°")


@pytest.fixture
def judge(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[tuple[str, int]]]:
    """Put given outcomes in place of gates and trials, and keep a list of those that were asked for."""

    def outcomes(gates: dict[int, GateRow], missed: tuple[int, ...] = ()) -> list[tuple[str, int]]:
        asked: list[tuple[str, int]] = []

        def gate(package: bytes, number: int) -> list[GateRow]:
            asked.append(("reference", number))
            seeds = range(tasks._effort(package, number).seeds)
            return [replace(gates.get(number, GateRow(0, "pass", True, 40)), seed=seed) for seed in seeds]

        def faults(_package: bytes, item: tuple[int, tuple[str, ...]]) -> list[dict[str, Any]]:
            number, names = item
            asked.extend((name, number) for name in names)
            caught = number not in missed
            return [
                {"fault": name, "check": "CNV-2", "caught": caught, "also_failing": [], "runs": 3}
                for name in names
            ]

        monkeypatch.setattr(run, "run_gate", gate)
        monkeypatch.setattr(run, "run_faults", faults)
        return asked

    return outcomes


def request(folder: Path, drives: int = 3, **changes: Any) -> DrivesRequest:
    return replace(
        DrivesRequest("half-bridge", drives, 0, (), SelftestEffort("quick", workers=1), folder / "out"),
        **changes,
    )


def shown(document: dict[str, Any]) -> str:
    stream = io.StringIO()
    show_drives(console_for(stream), document)
    return stream.getvalue()


def test_all_drives_passed_is_reported_with_what_that_leaves_open(judge, tmp_path: Path) -> None:
    judge({})
    document = selftest_on_drives(request(tmp_path), Display())
    assert (document["passed"], document["exit_code"], document["reference"]["count"]) == (True, 0, 3)
    assert document["reference"]["interval"] == pytest.approx([0.025 ** (1 / 3), 1.0])
    text = shown(document)
    assert "reference passes 3 of 3 drives, 100 % (95 % interval 29.2 to 100 %)" in text
    assert f"next: drivegate drive {tmp_path}/out/drives/001.toml" in text


def test_a_failed_check_is_reported_with_its_worst_drive(judge, tmp_path: Path) -> None:
    judge({1: GateRow(0, "fail", False, 40, (FAILED,)), 3: GateRow(0, "fail", False, 40, (WORSE,))})
    document = selftest_on_drives(request(tmp_path), Display())
    (failure,) = document["failures"]
    assert (document["passed"], document["exit_code"], document["reference"]["count"]) == (False, 1, 1)
    assert (failure["reason"], failure["numbers"], failure["worst"]["number"]) == ("CNV-1", [1, 3], 3)
    assert failure["worst"]["per_unit"] == document["drives"][2]["per_unit"]
    text = shown(document)
    assert "CNV-1: on 2 drives, 001, 003" in text
    assert "worst on drive 003, seed 0: moves by 4°; limit 1°" in text
    assert "facts at 900 rpm" in text
    assert f"next: drivegate check reference --drive {tmp_path}/out/drives/003.toml --effort quick" in text


def test_a_drive_passes_when_it_does_with_every_seed(judge, tmp_path: Path, monkeypatch) -> None:
    judge({})
    monkeypatch.setattr(
        run, "run_gate", lambda *_: [GateRow(0, "pass", True), GateRow(1, "fail", False, 1, (FAILED,))]
    )
    document = selftest_on_drives(
        request(tmp_path, 1, effort=SelftestEffort("quick", 2, workers=1)), Display()
    )
    assert not document["passed"]
    assert "--effort quick --seed 1" in shown(document)


def test_a_drive_that_cannot_be_judged_on_is_an_outcome(judge, tmp_path: Path) -> None:
    judge({2: GateRow(0, "refused", False, message="the speed is too high")})
    document = selftest_on_drives(request(tmp_path), Display())
    assert [(failure["reason"], failure["numbers"]) for failure in document["failures"]] == [("refused", [2])]
    assert "the speed is too high" in shown(document)


@pytest.mark.parametrize(
    ("error", "verdict"),
    [(InputError, "refused"), (HarnessFault, "harness fault"), (ZeroDivisionError, "harness fault")],
)
def test_what_a_gate_raises_ends_no_other(
    error: type[Exception], verdict: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def raising(*_: object) -> None:
        raise error("it is so")

    monkeypatch.setattr(tasks, "design_check", raising)
    package = tasks.packed(SelftestEffort("quick", 2), {7: load_drive("paper-5-phase")})
    rows = tasks.run_gate(package, 7)
    assert [(row.seed, row.verdict, row.passed) for row in rows] == [
        (seed, verdict, False) for seed in (0, 1)
    ]
    assert all("it is so" in row.message for row in rows)


def test_a_lack_of_memory_is_no_outcome_of_a_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    def raising(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(tasks, "design_check", raising)
    with pytest.raises(MemoryError):
        tasks.run_gate(tasks.packed(SelftestEffort("quick"), {7: load_drive("paper-5-phase")}), 7)


def test_faults_are_tried_only_where_the_reference_passes(judge, tmp_path: Path) -> None:
    asked = judge({2: GateRow(0, "fail", False, 40, (FAILED,))}, missed=(3,))
    document = selftest_on_drives(request(tmp_path, faults=(FAULT,)), Display())
    assert [number for name, number in asked if name == FAULT] == [1, 3]
    (fault,) = document["faults"]
    assert (fault["count"], fault["of"], fault["missed_on"]) == (1, 2, [3])
    assert document["trials"]["share"] == 0.5
    assert "faults caught in 1 of 2 trials" in shown(document)


def test_a_fault_that_does_nothing_on_a_drive_is_not_counted_there(
    judge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    judge({}, missed=(3,))
    tried = run.run_faults

    def idle_on_the_first(package: bytes, item: tuple[int, tuple[str, ...]]) -> list[dict[str, Any]]:
        why = "16 bits hold that" if item[0] == 1 else None
        return [outcome | {"caught": not why, "does_not_apply": why} for outcome in tried(package, item)]

    monkeypatch.setattr(run, "run_faults", idle_on_the_first)
    document = selftest_on_drives(request(tmp_path, faults=(FAULT,)), Display())
    (fault,) = document["faults"]
    assert (fault["count"], fault["of"], fault["missed_on"]) == (2, 2, [])
    assert fault["does_not_apply_on"] == {"001": "16 bits hold that"}
    assert (document["trials"]["count"], document["trials"]["of"]) == (2, 2)


def test_a_trial_that_breaks_ends_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    def tried(faults: tuple[SeededFault, ...], _effort: object) -> Iterator[FaultRow]:
        for fault in faults:
            if fault.name == "drifts":
                raise HarnessFault("the plant is lost")
            yield FaultRow(fault.name, "", "", fault.check, {0: None}, (), 4)

    monkeypatch.setattr(tasks, "try_faults", tried)
    package = tasks.packed(SelftestEffort("quick"), {7: load_drive("paper-5-phase")})
    outcomes = tasks.run_faults(package, (7, (FAULT, "drifts", "slow-step")))
    stated = [(outcome["fault"], outcome["runs"], outcome["message"]) for outcome in outcomes]
    assert stated == [(FAULT, 4, ""), ("drifts", 0, "the plant is lost"), ("slow-step", 4, "")]


def test_it_goes_on_where_it_stopped_and_comes_to_the_same(
    judge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gates = {2: GateRow(0, "fail", False, 40, (FAILED,))}
    judge(gates)
    whole = selftest_on_drives(request(tmp_path, output=tmp_path / "whole"), Display())
    judge(gates)
    gate = run.run_gate

    def interrupted(package: bytes, number: int) -> list[GateRow]:
        if number == 3:
            raise KeyboardInterrupt
        return gate(package, number)

    monkeypatch.setattr(run, "run_gate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        selftest_on_drives(request(tmp_path), Display())
    asked = judge(gates)
    again = selftest_on_drives(request(tmp_path), Display())
    assert asked == [("reference", 3)], "what is kept is not done again"
    names = {path.relative_to(tmp_path / "whole") for path in (tmp_path / "whole").rglob("*.toml")}
    assert names == {Path(f"drives/{number:03d}.toml") for number in (1, 2, 3)}
    for document in (whole, again):
        for drive in (*document["drives"], *(failure["worst"] for failure in document["failures"])):
            drive["file"] = Path(drive["file"]).name
        assert document.pop("timing")["made"] == (3 if document is whole else 1)
        assert document.pop("output")
    assert again == whole


def test_more_drives_and_faults_can_be_asked_for_later(judge, tmp_path: Path) -> None:
    judge({})
    selftest_on_drives(request(tmp_path, 2), Display())
    asked = judge({})
    selftest_on_drives(request(tmp_path, 3, faults=(FAULT,)), Display())
    assert asked == [("reference", 3), *((FAULT, number) for number in (1, 2, 3))]


@pytest.mark.parametrize(
    ("changes", "stated"),
    [
        ({"drawing_seed": 1}, "was begun with drawing seed 0, not 1"),
        ({"effort": SelftestEffort("default", workers=1)}, "was begun with effort quick, not default"),
        ({"effort": SelftestEffort("quick", 2, workers=1)}, "was begun with seeds 1, not 2"),
    ],
)
def test_other_results_are_not_mixed_in(changes: dict[str, Any], stated: str, judge, tmp_path: Path) -> None:
    judge({})
    selftest_on_drives(request(tmp_path, 1), Display())
    with pytest.raises(InputError, match=stated):
        selftest_on_drives(request(tmp_path, 1, **changes), Display())


def test_results_of_another_version_are_not_mixed_in(
    judge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    judge({})
    selftest_on_drives(request(tmp_path, 1), Display())
    monkeypatch.setattr("drivegate_lab.selftest.drawn.folder.versions", lambda: {"drivegate": "another"})
    with pytest.raises(InputError, match="begun with other versions of drivegate"):
        selftest_on_drives(request(tmp_path, 1), Display())


def test_a_drive_that_was_changed_is_refused(judge, tmp_path: Path) -> None:
    judge({})
    selftest_on_drives(request(tmp_path, 1), Display())
    file = tmp_path / "out" / "drives" / "001.toml"
    file.write_text(file.read_text().replace("phases = ", "phases = 1"))
    with pytest.raises(InputError, match="is not the drive that was drawn"):
        selftest_on_drives(request(tmp_path, 1), Display())


def test_a_broken_result_is_refused_with_the_way_out(judge, tmp_path: Path) -> None:
    judge({})
    selftest_on_drives(request(tmp_path, 1), Display())
    (tmp_path / "out" / "results" / "001.json").write_text("{")
    with pytest.raises(InputError, match=r"001\.json is not .*; delete it and run the same command again"):
        selftest_on_drives(request(tmp_path, 1), Display())


def test_a_row_comes_back_as_it_was_kept() -> None:
    row = GateRow(3, "fail", False, 40, (FAILED, WORSE), "by itself")
    assert row_from(row.document()) == row


def test_on_pm_ac_drives_foc_takes_the_place_of_the_reference(judge, tmp_path: Path) -> None:
    asked = judge({2: GateRow(0, "fail", False, 40, (replace(FAILED, check="FWK-1"),))})
    document = selftest_on_drives(request(tmp_path, kind="pm-ac", faults=("slow-currents",)), Display())
    assert [number for name, number in asked if name == "slow-currents"] == [1, 3]
    assert (document["drive_kind"], document["candidate"]) == ("pm-ac", "foc")
    assert load_drive(document["drives"][0]["file"]).kind == "pm-ac"
    text = shown(document)
    assert "foc passes 2 of 3 drives" in text
    assert "saliency" in text
    assert f"next: drivegate check foc --drive {tmp_path}/out/drives/002.toml" in text
    with pytest.raises(InputError, match="was begun with drive kind pm-ac, not half-bridge"):
        selftest_on_drives(request(tmp_path), Display())


def test_the_controller_and_the_faults_are_those_of_the_drive_s_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    surface = load_drive("pm-ac-surface")

    def named(design: Any, *_: object) -> Iterator[Any]:
        seen.append(design.candidate)
        raise HarnessFault("seen")

    def tried(faults: tuple[SeededFault, ...], _effort: SelftestEffort) -> Iterator[FaultRow]:
        seen.extend((fault.name, fault.check_on(surface)) for fault in faults)
        raise HarnessFault("seen")

    monkeypatch.setattr(tasks, "design_check", named)
    monkeypatch.setattr(tasks, "try_faults", tried)
    package = tasks.packed(SelftestEffort("quick"), {7: surface})
    tasks.run_gate(package, 7)
    tasks.run_faults(package, (7, ("angle-offset",)))
    assert seen == ["foc", ("angle-offset", "FWK-2")]
