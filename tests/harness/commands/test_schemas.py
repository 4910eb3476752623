"""The schemas of files that users write take every file of the repository, and refuse what drivegate refuses."""

from __future__ import annotations

import json
import re
import tomllib
from datetime import date
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from drivegate.commands.file_schemas import SCHEMAS, schema_file
from drivegate.commands.schema import NAMES

ROOT = Path(__file__).parents[3]
CASES = ROOT / "reference_cases" / "drivegate_cases"
EXAMPLES = ROOT / "examples"


def files_of(name: str) -> list[Path]:
    return {
        "drive": sorted((CASES / "drives").glob("*.toml")),
        "scenario": [
            *sorted((CASES / "scenarios").glob("*.toml")),
            EXAMPLES / "campaign" / "pm-ac-step-up.toml",
        ],
        "candidate": sorted(EXAMPLES.rglob("candidate.toml")),
        "campaign": [
            file for file in sorted((EXAMPLES / "campaign").glob("*.toml")) if "step-up" not in file.name
        ],
        "waivers": [],
        "requirements": sorted((ROOT / "docs").glob("requirements*.toml")),
    }[name]


def as_json(value: Any) -> Any:
    """Write a document as an editor sees it: a day as text."""
    return json.loads(
        json.dumps(value, default=lambda day: day.isoformat() if isinstance(day, date) else day)
    )


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_published_schema_is_that_of_the_document_and_takes_all_files(name: str) -> None:
    published = json.loads((ROOT / "docs" / "schemas" / schema_file(name)).read_text(encoding="utf-8"))
    assert published == SCHEMAS[name](), (
        f"{schema_file(name)} is out of date; drivegate schema {name} > docs/schemas/{schema_file(name)}"
    )
    jsonschema.Draft202012Validator.check_schema(published)
    for file in files_of(name):
        jsonschema.validate(as_json(tomllib.loads(file.read_text(encoding="utf-8"))), published)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"schema": 1, "misspelt": 1}, published)


def test_every_schema_has_a_command() -> None:
    assert tuple(SCHEMAS) == NAMES


def test_a_row_is_completed_by_its_quantities_and_events() -> None:
    schema = SCHEMAS["requirements"]()
    row = {"id": "R", "text": "It is so.", "quantity": "speed_rpm", "at_most": 1, "when": "step of load"}
    jsonschema.validate({"schema": 1, "requirement": [row]}, schema)
    for change in ({"quantity": "speed_rps"}, {"when": "step of laod"}, {"when": {"speed_rmp": [0, 1]}}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"schema": 1, "requirement": [row | change]}, schema)
    scenario = {"name": "s", "duration_s": 1.0, "speed_rpm": [[0, 1]], "load": {"kind": "locked"}}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"schema": 1, "requirement": [row], "scenario": [{}]}, schema)
    jsonschema.validate({"schema": 1, "requirement": [row], "scenario": [scenario]}, schema)


@pytest.mark.parametrize("name", ["candidate", "waivers"])
def test_templates_name_their_schema_first(name: str) -> None:
    templates = ROOT / "harness" / "drivegate" / "templates" / "new"
    for file in templates.rglob(f"{name}.toml"):
        assert re.match(rf"#:schema schemas/{name}\.schema\.json\n", file.read_text(encoding="utf-8")), file
