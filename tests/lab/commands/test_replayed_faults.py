"""Counterexamples of the laboratory's controllers are replayed by their names alone."""

import json

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario

SCENARIO = load_scenario("lock-up").replaced(duration_s=12.0)


def counterexample(**changes):
    table = {
        "schema": 2,
        "kind": "counterexample",
        "check": "CNV-1",
        "margin": -2.5,
        "measured": "speed error 17.5 rpm",
        "candidate": {"name": "published", "hash": "00ff"},
        "scenario": SCENARIO.to_mapping(),
    }
    return table | changes


@pytest.fixture
def file(tmp_path):
    """Write a counterexample with some of its keys changed."""

    def write(**changes):
        path = tmp_path / "found" / "CNV-1.json"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(counterexample(**changes)), encoding="utf-8")
        return path

    return write


@pytest.fixture
def script(file):
    """Write a script that a flowchart without k2 does not follow."""
    row = {"speed_reference_rpm": 1500.0, "speed_rpm": 1500.0, "supply_v": 48.0}
    sums = (40.0, 38.0, 36.0, 35.999, 35.998, 35.997)
    table = {
        "schema": 1,
        "kind": "script",
        "name": "hardly any change",
        "drive": load_drive("paper-5-phase").to_mapping(),
        "rows": [row | {"current_sum_a": current} for current in sums],
    }
    return lambda name: file(check="FLO-1", scenario=table, candidate={"name": name})


def test_a_script_is_replayed(command, script, tmp_path):
    words = ("replay", script("faulty:flowchart-without-k2"))
    text, data = command(*words), command(*words, "--plot", "rows.svg", "--json")
    assert text.code == data.code == 1, text.err
    assert "FLO-1 STILL FAILS" in text.out
    assert "in hardly any change, row " in text.out
    assert data.document["rows"][0] == data.document["rows"][1] >= 3, (
        "the row of the first departure is reported"
    )
    assert data.document["window_s"] is None
    assert "judged here" in (tmp_path / "rows.svg").read_text(encoding="utf-8")
    right = command("replay", script("published"), "--json")
    assert (right.code, right.document["verdict"]) == (0, "fixed")
    other = command("replay", script("reference"))
    assert other.code == 0
    assert "does not declare the profile 'flowchart'" in other.out


def test_a_name_that_only_looks_built_in_is_refused(refused, file, tmp_path):
    (tmp_path / "faulty.py").write_text("open('owned', 'w')", encoding="utf-8")
    assert "'nobody' is unknown" in refused("replay", file(candidate={"name": "faulty:nobody"}))
    (tmp_path / "design.py").write_text("open('owned', 'w')", encoding="utf-8")
    refused("replay", file(candidate={"name": "design:nobody"}))
    assert not (tmp_path / "owned").exists()
