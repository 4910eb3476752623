"""`drivegate check` with requirements of one's own, from the file to the page, and back from a counterexample."""

from __future__ import annotations

import json
import pickle
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import checks_of
from drivegate.contracts.duty.scenarios.building import load_step_scenario, torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.own_requirements import require_fitting, with_requirements
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.requirements.file import OwnRequirements, read_requirements
from drivegate_cases.requirements.row import Row
from drivegate_models.errors import InputError

DRIVE = load_drive("pm-ac-interior").replaced(settling_s=0.2)
assert isinstance(DRIVE, PmAcDocument)
STEP = load_step_scenario(DRIVE, 1000.0, 1.0, (0.0, 1.0))
FILE = """
schema = 1

[[requirement]]
id = "REQ-back"
text = "After a load step the speed is back within 1 rpm in 1 ms."
when = "step of load"
between_s = [0.001]
quantity = "speed_deviation_rpm"
statistic = "absolute"
at_most = 1.0

[[requirement]]
id = "REQ-current"
text = "The phase current stays below 60 A {always}."
quantity = "peak_current_a"
at_most = 60.0

[[requirement]]
id = "REQ-failed"
text = "A drive whose sensor failed lets go in 10 ms."
when = "failure"
between_s = [0.01]
quantity = "peak_current_a"
at_most = 1.0
level = "advisory"

[[scenario]]
name = "a step of its own"
duration_s = 0.6
speed_rpm = [[0.0, 500.0]]
load = { kind = "constant_torque", torque_nm = 0.5, factor = [[0.0, 0.0], [0.3, 0.0], [0.3, 1.0]] }
"""
QUICK = ("check", "foc", "--effort", "quick", "--workers", "1", "--contested", "fail")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "requirements.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, little_shrunk: None, undrawn: None) -> None:
    """Two fixed scenarios, and one drawn at most, on a drive that settles soon."""
    held = torque_scenario(DRIVE, 1000.0, (0.0, 1.0))
    monkeypatch.setattr("drivegate.contracts.duty.contract.fixed_scenarios", lambda *_, **__: (STEP, held))
    monkeypatch.setattr("drivegate.gate.plan.SHARDS", 1)
    monkeypatch.setattr("drivegate.gate.plan.EXAMPLES", {"quick": 1})


def test_rows_are_checked_reported_waived_and_replayed(
    command: Any, small: None, file: Path, tmp_path: Path
) -> None:
    ended = command(*QUICK, "--only", "req", "--requirements", file, "--json")
    outcomes = {check["id"]: check for check in ended.document["checks"]}
    assert {name: check["verdict"] for name, check in outcomes.items()} == {
        "REQ-back": "fail",
        "REQ-current": "pass",
        "REQ-failed": "never judged",
    }
    assert ended.code == 1
    assert outcomes["REQ-current"]["requirement"] == "The phase current stays below 60 A {always}."
    assert "a step of its own" in {run["name"] for run in ended.document["fixed"]}
    assert "it has no failure" in outcomes["REQ-failed"]["message"]
    failed = outcomes["REQ-back"]
    assert failed["witness"] is not None or "contested" in failed["message"]
    assert failed["recording"]["closeup"]["moment"]["column"] == "speed_rpm"

    report = tmp_path / "drivegate-report"
    page = (report / "report.html").read_text(encoding="utf-8")
    assert "After a load step the speed is back within 1 rpm in 1 ms." in page
    assert "every step of load, from 0.001 s after it begins" in page, "from requirement to evidence"
    cases = ElementTree.parse(report / "junit.xml").iter("testcase")
    names = {case.get("name"): [child.tag for child in case] for case in cases}
    assert names["REQ-back"] == ["failure"]

    stored = report / "counterexamples" / "REQ-back.json"
    replay = command("replay", stored, "--json").document
    assert replay["verdict"] == "still fails"
    assert replay["now"]["margin"] == pytest.approx(failed["found"]["margin"])

    waivers = tmp_path / "waivers.toml"
    waivers.write_text(
        'schema = 1\n[[waiver]]\ncheck = "REQ-back"\ncandidate = "foc"\ndrive = "pm-ac-interior"\n'
        'reason = "it is known"\n'
        'owner = "Ada"\nexpires = 2999-12-31\nmargin = -1e6\n',
        encoding="utf-8",
    )
    words = ("--requirements", file, "--waivers", waivers, "--only", "REQ-back", "--json")
    again = command(*QUICK, *words)
    assert (again.code, again.document["verdict"]) == (0, "waived")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            {"quantity": "advance_deg"},
            "limits advance_deg, which runs on the drive 'pm-ac-interior' do not show",
        ),
        (
            {"quantity": "winding_temperature_c"},
            "limits winding_temperature_c, which runs on the drive 'pm-ac-interior' do not show",
        ),
        ({"at_most": 2e9}, "is it in another unit?"),
        ({"id": "ovc-1"}, "has the identifier of a check of drivegate"),
        ({"between_s": (300.0,)}, "has a window that begins after 300 s, but the drive settles in 0.2 s"),
        ({"statistic": "time until", "until": (0.0, 1.0), "at_most": 300.0}, "waits for at most 300 s"),
    ],
)
def test_a_row_that_does_not_fit_the_drive_is_refused(change: dict[str, Any], sentence: str) -> None:
    keys = {"id": "REQ-1", "text": "It is so.", "quantity": "speed_rpm", "at_most": 1.0} | change
    own = OwnRequirements((Row.model_validate(keys),))
    declaration = with_requirements(resolve_candidate("foc"), own).declaration
    with pytest.raises(InputError) as refused:
        require_fitting(declaration, DRIVE)
    assert sentence in str(refused.value)


def test_an_event_that_cannot_occur_is_refused() -> None:
    row = Row.model_validate(
        {"id": "R", "text": "It is so.", "when": "failure", "quantity": "speed_rpm", "at_most": 1.0}
    )
    declaration = with_requirements(resolve_candidate("reference"), OwnRequirements((row,))).declaration
    with pytest.raises(InputError, match="cannot occur on a drive of the contract 'current'"):
        require_fitting(declaration, load_drive("paper-5-phase"))


def test_rows_reach_another_process_and_say_the_same_there(file: Path) -> None:
    candidate = with_requirements(resolve_candidate("foc"), read_requirements(file))
    margins = []
    for each in (candidate, pickle.loads(pickle.dumps(candidate))):
        loaded = own_candidate(each)
        record = recorded(loaded, STEP, loaded.controller())
        margins.append(judged(record, checks_of(DRIVE, each.declaration)).margins)
    assert margins[0] == margins[1]
    assert {"REQ-back", "REQ-current", "OVC-1"} <= {margin.check for margin in margins[0]}
    plain = own_candidate(resolve_candidate("foc"))
    without = judged(recorded(plain, STEP, plain.controller()), checks_of(DRIVE, plain.candidate.declaration))
    assert without.margins == tuple(each for each in margins[0] if not each.check.startswith("REQ"))


def test_rows_are_listed_with_the_checks(command: Any, file: Path) -> None:
    listed = command("checks", "--requirements", file, "--json").document["checks"]
    rows = {entry["id"]: entry for entry in listed if entry["source"] == "own requirement"}
    assert list(rows) == ["REQ-back", "REQ-current", "REQ-failed"]
    assert rows["REQ-back"]["limit"] == "absolute speed deviation at most 1 rpm"
    assert rows["REQ-back"]["scenarios"] == "every step of load, from 0.001 s after it begins"
    assert rows["REQ-failed"]["level"] == "advisory"
    assert "OVC-1" in {entry["id"] for entry in listed}


def test_a_manifest_names_its_requirements(tmp_path: Path, file: Path) -> None:
    (tmp_path / "controller.py").write_text("class C: pass\n", encoding="utf-8")
    manifest = tmp_path / "candidate.toml"
    text = 'schema = 1\nname = "mine"\nkind = "python"\nentry = "controller.py:C"\ncontract = "duty"\n'
    manifest.write_text(f'{text}requirements = "requirements.toml"\n', encoding="utf-8")
    own = resolve_candidate(str(manifest)).declaration.requirements
    assert own is not None
    assert [row.id for row in own.rows] == ["REQ-back", "REQ-current", "REQ-failed"]
    written = json.loads(own.scenarios[0])
    assert written["name"] == "a step of its own"
    file.unlink()
    with pytest.raises(InputError, match=r"requirements\.toml does not exist"):
        resolve_candidate(str(manifest))
