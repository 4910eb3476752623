"""`drivegate bench`: what it prints, keeps, compares and refuses."""

import json

import pytest

from drivegate.drives.kinds import HALF_BRIDGE
from drivegate_cases.documents.document import parse_document
from drivegate_lab.bench import measurements
from drivegate_lab.bench.measurements import gate_time, start_time
from drivegate_lab.bench.plan import Planned
from drivegate_lab.bench.record import BenchDocument, bench_document, compared_with
from drivegate_lab.bench.workbench import Correctness, NotMeasured, Value

QUICK = ("--quick", "--only", "loop.reference.1500.ideal", "--only", "start.import")
NAME = "loop.reference.1500.ideal"


@pytest.fixture
def short(monkeypatch):
    """Runs of half a second, so that a test takes little more."""
    monkeypatch.setitem(measurements.SIMULATED, "reference", 1.0)


def test_it_measures_keeps_and_compares(bench, short, tmp_path):
    first = bench(*QUICK, "--json", "--output", "first.json")
    assert first.code == 0, first.err
    saved = json.loads((tmp_path / "first.json").read_text())
    assert saved == first.document
    row = first.row(NAME)
    assert (row["valid"], row["unit"], row["bar"]) == (True, "× real time", 300.0)
    assert row["value"] > 1.0
    assert "rpm, energy within" in row["check"]
    assert saved["valid"] is True
    assert set(saved["machine"]) == {"system", "processor", "processors"}
    assert len(saved["load_average"]) == 2
    assert saved["provenance"]["packages"]["numba"]
    assert saved["command"] == f"drivegate bench --quick --only {NAME} --only start.import"
    second = bench(*QUICK, "--compare", "first.json", "--output", "second.json")
    assert second.code == 0, second.err
    again = json.loads((tmp_path / "second.json").read_text())
    now = next(found for found in again["rows"] if found["name"] == NAME)
    assert now["earlier"] == row["value"]
    assert now["times_as_good"] == pytest.approx(now["value"] / row["value"])
    assert again["compared"]["rows"] == 2
    assert again["compared"]["same_machine"] is True
    assert "× as good" in second.out
    assert "written: second.json" in second.out
    third = bench("--quick", "--only", "start.import", "--compare", "second.json", "--json")
    assert third.code == 0, "a file that holds a comparison itself can be compared with"


def test_a_wrong_result_is_exit_code_1(bench, short, monkeypatch):
    monkeypatch.setattr(measurements, "ENERGY_TOLERANCE", -1.0)
    ended = bench("--quick", "--only", NAME, "--json")
    assert ended.code == 1
    assert ended.document["valid"] is False
    assert ended.row(NAME)["valid"] is False
    shown = bench("--quick", "--only", NAME)
    assert shown.code == 1
    assert f"wrong results, so that their times say nothing: {NAME}" in shown.out


def test_a_missing_compiler_is_reported_and_fails_nothing(bench, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    ended = bench("--quick", "--only", "loop.c.1500.ideal", "--json")
    assert ended.code == 0
    row = ended.row("loop.c.1500.ideal")
    assert (row["value"], row["valid"]) == (None, None)
    assert "no-such-compiler" in row["check"]
    assert "no-such-compiler" in bench("--quick", "--only", "loop.c.1500.ideal").out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--only", "lop"), "the nearest is 'loop'"),
        (("--compare", "missing.json"), "missing.json does not exist"),
        (("--compare", "other.json"), "'kind' is \"check\", but must be 'bench'"),
        (("--compare", "broken.json"), "broken.json"),
        (("--output", "missing/bench.json"), "its folder does not exist"),
        (("--output", "bench.txt"), "must end in .json"),
        (("--bogus",), "--bogus"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(bench, tmp_path, words, sentence):
    (tmp_path / "other.json").write_text(json.dumps({"schema": 1, "kind": "check"}))
    (tmp_path / "broken.json").write_text('{"schema": 1,')
    before = sorted(tmp_path.iterdir())
    text, data = bench(*words), bench(*words, "--json")
    assert text.code == data.code == 2, text.err
    assert text.out == ""
    lines = text.err.strip().splitlines()
    assert len(lines) == 1, text.err
    assert sentence in lines[0]
    assert data.document["error"]["message"] == lines[0].removeprefix("error: ")
    assert sorted(tmp_path.iterdir()) == before


def document(*rows):
    from datetime import UTC, datetime

    return bench_document(
        rows,
        command="drivegate bench",
        started=datetime.now(UTC),
        seconds=1.0,
        load_average=(0.5, None),
    )


def row(name, value, better="more", setting="4 s", valid=True):
    def measure(_bench):
        if value is None:
            raise NotMeasured("no tool")
        return Value(value, value, 3, Correctness(valid, "measured"))

    return Planned(name, "title", setting, "unit", better, None, measure).row(None)


def test_only_a_wrong_result_makes_a_document_invalid():
    wrong, right, missing = row("wrong", 1.0, valid=False), row("right", 1.0), row("missing", None)
    assert not document(right, wrong)["valid"]
    assert document(right, missing)["valid"]
    written = document(missing)["rows"][0]
    assert (
        written | {"value": None, "median": None, "rounds": 0, "valid": None, "check": "no tool"} == written
    )
    assert not {"earlier", "times_as_good"} & set(written), "it was compared with nothing"


def test_only_the_same_work_is_compared_and_above_one_is_better(tmp_path):
    names = {
        "rate": (row("rate", 10.0), row("rate", 20.0), 2.0),
        "time": (row("time", 10.0, "less"), row("time", 20.0, "less"), 0.5),
        "other": (row("other", 10.0, setting="2 s"), row("other", 20.0), None),
        "was wrong": (row("was wrong", 10.0, valid=False), row("was wrong", 20.0), None),
        "is wrong": (row("is wrong", 10.0), row("is wrong", 20.0, valid=False), None),
        "missing": (row("missing", 10.0), row("missing", None), None),
        "was missing": (row("was missing", None), row("was missing", 20.0), None),
    }
    earlier = parse_document(document(*(one[0] for one in names.values())), BenchDocument, "earlier")
    compared = compared_with(document(*(one[1] for one in names.values())), earlier, tmp_path / "old.json")
    found = {one["name"]: one["times_as_good"] for one in compared["rows"]}
    assert found == {name: expected for name, (_, _, expected) in names.items()}
    assert compared["compared"]["rows"] == 2
    elsewhere = compared_with(
        document() | {"machine": {"processor": "another"}}, earlier, tmp_path / "old.json"
    )
    assert elsewhere["compared"]["same_machine"] is False


def test_a_gate_is_right_only_with_its_verdict(workbench, monkeypatch):
    seen = []

    def ended(code, verdict):
        def run(words, folder, environment):
            seen.append((words, dict(environment)))
            return code, json.dumps({"verdict": verdict, "runs": 3})

        monkeypatch.setattr(measurements, "_ended", run)

    ended(0, "pass")
    assert gate_time(workbench, "quick", kind=HALF_BRIDGE, cold=False).correctness.valid
    ended(1, "fail")
    assert not gate_time(workbench, "quick", kind=HALF_BRIDGE, cold=False).correctness.valid
    assert seen[0][0][2:6] == ("check", "reference", "--drive", "paper-5-phase")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/nowhere")
    ended(0, "pass")
    gate_time(workbench, "quick", kind=HALF_BRIDGE, cold=True)
    environment = seen[-1][1]
    assert "NUMBA_CACHE_DIR" not in environment, "it would win over the empty folder"
    assert environment["DRIVEGATE_CACHE"].startswith(str(workbench.scratch))


def test_a_start_is_right_only_with_its_answer(workbench):
    assert start_time(workbench, ("-c", "print('here')"), "here").correctness.valid
    assert not start_time(workbench, ("-c", "print('gone')"), "here").correctness.valid
    assert not start_time(workbench, ("-c", "print('here'); raise SystemExit(1)"), "here").correctness.valid
