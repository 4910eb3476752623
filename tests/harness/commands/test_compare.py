"""`drivegate compare`: end to end, with a plan that is small."""

import csv
import json

import pytest

from drivegate.contracts.current.comparison import plan as comparison_plan
from drivegate.studies.compare import engine
from drivegate.studies.compare.compare import table_text
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

SMALL = comparison_plan.ComparisonEffort((0.2, 1.0), (0.25, 1.0), 1, 1, 3)
CYCLE = "time_s,speed_km_h\n0,0\n1,0\n5,15\n7,15\n11,0\n12,0\n"


@pytest.fixture
def compare(command, monkeypatch, tmp_path):
    """Compare over a small plan and a short cycle."""
    monkeypatch.setitem(comparison_plan.EFFORTS, "quick", SMALL)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1900000000")
    (tmp_path / "short.csv").write_text(CYCLE, encoding="utf-8")

    def run(*words):
        return command("compare", *words, "--effort", "quick", "--cycle", "short.csv", "--no-checks")

    return run


def test_the_built_in_candidates_are_compared_the_same_on_any_number_of_workers(
    compare, undrawn, tmp_path, monkeypatch
):
    ended = compare("reference", "initial", "published", "--workers", 2, "--output", "two", "--json")
    assert ended.code == 0, ended.err
    document = ended.document
    assert document["kind"] == "comparison"
    ranking = document["tables"]["ranking"]
    assert [(row["rank"], row["candidate"]) for row in ranking] == [
        (1, "reference"),
        (2, "initial"),
        (3, "published"),
    ]
    assert ranking[0]["points_held"] == ranking[0]["points_feasible"] == 4
    assert ranking[2]["points_held"] < 4, "the literal flowchart loses full load"
    assert ranking[1]["current_above_first_a"] > 1.0, "without a search Σ|i| is higher"
    assert document["timing"]["started_utc"] == "2030-03-17"
    assert {row["candidate"] for row in document["timing"]["steps"]} == {"reference", "initial", "published"}

    page = (tmp_path / "two" / "comparison.html").read_text(encoding="utf-8")
    assert "reference ranks first" in page
    table = (tmp_path / "two" / "tables" / "operating_points.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(table.splitlines()))
    assert len(rows) == 12
    assert rows[0]["candidate"] == "reference"

    # The page is a function of the document, and what a candidate is measured as does not depend on the others.
    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [])
    alone = compare("initial", "--workers", 1, "--output", "one", "--json").document
    for table in ("operating_points", "disturbances", "repetitions", "drive_cycle"):
        rows = [row for row in document["tables"][table] if row["candidate"] == "initial"]
        assert json.dumps(rows) == json.dumps(alone["tables"][table]), (
            f"{table} depends on the number of workers"
        )


@pytest.mark.nightly
def test_drives_are_put_side_by_side_the_same_on_any_number_of_workers(
    compare, undrawn, tmp_path, monkeypatch
):
    drives = ("--drive", "paper-5-phase", "--drive", "fan-3-phase")
    ended = compare("initial", "nonsense", *drives, "--workers", 2, "--output", "two", "--json")
    assert ended.code == 2, ended.err
    assert ended.err.count("the candidate 'nonsense' is unknown") == 1, "it has nothing to do with a drive"
    assert "initial on fan-3-phase" in ended.err, "progress states the drive"
    document = ended.document
    assert document["kind"] == "drive-comparison"
    assert [entry["label"] for entry in document["drives"]] == ["paper-5-phase", "fan-3-phase"]
    rows = document["tables"]["operating_points"]
    statuses = [(row["candidate"], row["status"]) for row in document["tables"]["summary"]]
    assert statuses == [("initial", "compared")] * 2 + [("nonsense", "refused")] * 2
    at_full = [
        (row["drive"], row["speed_rpm"], round(row["speed_pu"], 3))
        for row in rows
        if row["load_percent"] == 100.0
    ]
    assert at_full == [
        ("paper-5-phase", 700.0, 1.4),
        ("paper-5-phase", 1500.0, 3.0),
        ("fan-3-phase", 2800.0, 1.4),
        ("fan-3-phase", 6000.0, 3.0),
    ], "each drive runs at the shares of its own range"
    assert all(row["held"] for row in rows), (
        "the line of angles of each drive's own nameplate holds its rating"
    )
    assert all(0.02 < row["losses_pu"] < 0.5 for row in rows)

    page = (tmp_path / "two" / "drive-comparison.html").read_text(encoding="utf-8")
    assert "paper-5-phase and fan-3-phase under the same controllers" in page
    assert (tmp_path / "two" / "drive-2" / "comparison.html").is_file()
    assert (tmp_path / "two" / "tables" / "summary.csv").is_file()

    # What is measured depends neither on the workers nor on the other drive.
    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [])
    one_drive = ("--drive", "fan-3-phase", "--workers", 1, "--output", "alone")
    alone = compare("initial", "nonsense", *one_drive, "--json").document
    kept = ((tmp_path / "two" / "drive-2" / "comparison.json"), (tmp_path / "alone" / "comparison.json"))
    part, by_itself = (json.loads(path.read_text(encoding="utf-8")) for path in kept)
    for made in (part, by_itself, alone):
        del made["timing"]
    assert part == by_itself == alone, "the comparison on one drive is the same document beside another"


def test_drives_that_cannot_be_compared_are_refused(refused, tmp_path):
    said = refused("compare", "initial", "--drive", "paper-5-phase", "--drive", "paper-5-phase")
    assert "have the same values" in said
    assert "'nonsense' is unknown" in refused(
        "compare", "nonsense", "--drive", "paper-5-phase", "--drive", "fan-3-phase"
    )
    assert "no drive is called 'fan'" in refused(
        "compare", "initial", "--drive", "paper-5-phase", "--drive", "fan"
    )
    weak = load_drive("fan-3-phase").replaced(current_limit_a=3.0)
    (tmp_path / "weak.json").write_text(json.dumps(weak.to_mapping()), encoding="utf-8")
    said = refused("compare", "initial", "--drive", "paper-5-phase", "--drive", "weak.json")
    assert "no controller can meet what the drive 'fan-3-phase' requires" in said


def test_every_drive_is_refused_once_its_kernels_are_compiled(command, monkeypatch):
    compiled = []

    def refuse(drive):
        if drive.name == "star-3-phase":
            raise InputError(f"with {compiled} compiled")

    monkeypatch.setattr(engine, "uncompiled_kinds", lambda drives: tuple(drive.kind for drive in drives))
    monkeypatch.setattr(engine, "compile_kernels", compiled.extend)
    monkeypatch.setattr("drivegate.studies.compare.compare.refuse_unreachable", refuse)
    ended = command("compare", "initial", "--drive", "fan-3-phase", "--drive", "star-3-phase")
    assert ended.code == 2
    first, second, refusal = ended.err.splitlines()
    assert first.startswith("comparison: compiling the kernels, which is done once and takes about 20 s")
    assert second.startswith("comparison: compiling the kernels, which is done once and takes about 20 s")
    assert refusal == "error: with ['half-bridge', 'star'] compiled"


def test_who_fails_or_is_refused_does_not_stop_the_others(compare, undrawn, controllers, tmp_path):
    ended = compare("nonsense", "initial", f"{controllers}:Raising", "--workers", 1, "--json")
    assert ended.code == 2
    assert "error: nonsense: the candidate 'nonsense' is unknown" in ended.err
    assert "Traceback" not in ended.err
    ranking = ended.document["tables"]["ranking"]
    assert [(row["rank"], row["status"]) for row in ranking] == [
        (1, "compared"),
        (None, "faulted"),
        (None, "refused"),
    ]
    faults = ended.document["candidates"][2]["faults"]
    assert [fault["kind"] for fault in faults] == ["exception"] * 3, (
        "after three faults it is not run any further"
    )
    assert "\x1b" not in faults[0]["message"]
    page = (tmp_path / "drivegate-comparison" / "comparison.html").read_text(encoding="utf-8")
    assert "nonsense" in page
    assert "ValueError" in page


def test_nothing_is_written_where_nothing_can_be_compared(refused):
    assert "'nonsense' is unknown" in refused("compare", "nonsense")


def test_a_bad_cycle_is_reported(refused, tmp_path):
    (tmp_path / "bad.csv").write_text("time_s\n0\n", encoding="utf-8")
    assert "bad.csv has no column 'speed_km_h'" in refused("compare", "initial", "--cycle", "bad.csv")
    assert "no drive cycle is called 'ece'" in refused("compare", "initial", "--cycle", "ece")


def test_a_table_is_safe_to_open():
    text = table_text([{"name": "=1+1", "value": 0.5, "held": True}, {"name": "a\x1bb", "more": None}])
    assert text == "name,value,held,more\n'=1+1,0.5,yes,\na\\x1bb,,,\n"
