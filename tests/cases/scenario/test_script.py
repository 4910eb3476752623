"""Scripts as documents: what they hold, and what is wrong with those that are refused."""

import json

import pytest

from drivegate_cases.documents.document import parse_document, read_document
from drivegate_cases.scenario.script import Script
from drivegate_models.errors import InputError

ROW = {"speed_reference_rpm": 1500.0, "speed_rpm": 1495.0, "current_sum_a": 40.0, "supply_v": 48.0}
SCRIPT = {"schema": 1, "kind": "script", "name": "two rows", "drive": "paper-5-phase", "rows": [ROW, ROW]}


def parsed(**changes):
    return parse_document({**SCRIPT, **changes}, Script, "a script")


def test_a_script_resolves_its_drive():
    script = parsed()
    assert script.drive.name == "paper-5-phase"
    assert script.control_period_s == 0.0005
    nameplate = script.nameplate()
    assert (nameplate.control_period, nameplate.phases) == (0.0005, 5)


def test_a_script_survives_its_own_mapping(tmp_path):
    script = parsed(control_period_s=0.0004, description="twice the same")
    assert parse_document(script.to_mapping(), Script, "a script") == script
    file = tmp_path / "script.json"
    file.write_text(json.dumps(script.to_mapping()))
    assert read_document(file, Script) == script


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"rows": []}, "'rows'"),
        ({"rows": [{**ROW, "speed_rpm": 500.0}]}, "must have speeds above the drive's base speed of 500 rpm"),
        ({"rows": [{**ROW, "supply_v": 0.0}]}, "'rows[0].supply_v'"),
        ({"rows": [{**ROW, "current_sum_a": -1.0}]}, "'rows[0].current_sum_a'"),
        ({"kind": "scenario"}, "'kind'"),
        ({"control_period_s": 0.001}, "'control_period_s'"),
        ({"drive": "paper-6-phase"}, "no drive is called 'paper-6-phase'"),
        ({"schema": 2}, "schema 2 is newer"),
        ({"raws": []}, "'raws'"),
    ],
)
def test_a_wrong_script_is_reported_in_one_sentence(changes, sentence):
    with pytest.raises(InputError) as raised:
        parsed(**changes)
    assert sentence in str(raised.value), raised.value
    assert "\n" not in str(raised.value)
