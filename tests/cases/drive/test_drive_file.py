"""The file of a drive: every key with a comment, read back as the same drive; its schema is published."""

import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.drive_file import drive_schema, drive_toml, toml_value

PAPER = load_drive("paper-5-phase")
SCHEMA_FILE = Path(__file__).parents[3] / "docs" / "schemas" / "drive.schema.json"
STRANGE = 'a "name" with \\ and é, Ω, \x7f and\ta tab'


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"emf_shape": "sine", "emf_flat_deg": None},
        {"emf_shape": "table", "emf_table": ((0.0, 0.0), (60.0, 1.0), (180.0, 0.0))},
        {"start_deg": 33.0, "slope_deg_per_rpm": 0.025},
        {"name": STRANGE, "provenance": {"machine": {"phases": STRANGE}}},
        {"provenance": {}},
        {"turn_on_energy_j": 1e-7, "rated_power_w": 1e7},
    ],
)
def test_what_is_written_is_read_back_as_the_same_drive(changes: dict[str, Any]) -> None:
    drive = PAPER.replaced(**changes)
    read = parse_document(tomllib.loads(drive_toml(drive)), DriveDocument, "the file")
    assert read == drive


def test_every_key_has_its_comment_also_one_that_is_left_out() -> None:
    lines = drive_toml(PAPER).splitlines()
    for model in DriveDocument.tables.values():
        for key, field in model.model_fields.items():
            named = [line for line in lines if line.removeprefix("# ").startswith(f"{key} =")]
            assert len(named) == 1, f"{key} is written {len(named)} times"
            assert named[0].endswith(f"# {field.description}"), named[0]


def test_a_list_of_tables_is_written_in_one_line() -> None:
    points = [{"speed_rpm": 1500.0, "torque_n_m": 9.8}, {"speed_rpm": 900.0, "torque_n_m": 1e-7}]
    line = f"point = {toml_value(points)}"
    assert "\n" not in line
    assert tomllib.loads(line) == {"point": points}


def test_a_left_out_table_is_a_comment_as_a_whole() -> None:
    text = drive_toml(parse_document(PAPER.to_mapping() | {"advance": None}, DriveDocument, "a drive"))
    assert "# [advance] " in text
    assert "# start_deg =" in text
    assert "\n[advance]" in drive_toml(PAPER)


def test_the_published_schema_is_that_of_the_document() -> None:
    assert json.loads(SCHEMA_FILE.read_text(encoding="utf-8")) == drive_schema(), (
        "docs/schemas/drive.schema.json is out of date; write it again from drivegate_cases.drive.drive_file"
    )


def test_the_schema_takes_a_drive_and_refuses_an_unknown_key() -> None:
    jsonschema.validate(PAPER.to_mapping(), drive_schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(PAPER.to_mapping() | {"phases": 5}, drive_schema())
