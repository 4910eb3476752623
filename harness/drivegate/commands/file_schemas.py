"""The JSON Schema of every file that users write, by which editors complete and check it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.document import Document

Schema = dict[str, Any]
FOLDER: Final = "schemas"
"""Folder next to a template that has the schemas which its files name."""


def _drive() -> Schema:
    from drivegate_cases.drive.drive_file import drive_schema

    return drive_schema()


def _scenario() -> Schema:
    from drivegate_cases.scenario.scenario import scenario_schema

    return scenario_schema()


def _candidate() -> Schema:
    from drivegate.candidates.manifest import Manifest

    return _of(Manifest, "candidate")


def _campaign() -> Schema:
    from drivegate.studies.campaign.file import Campaign

    return _of(Campaign, "campaign")


def _waivers() -> Schema:
    from drivegate.results.waivers import WaiverFile

    return _of(WaiverFile, "waivers")


def _requirements() -> Schema:
    """Make the schema of rows; their scenarios are others without a drive, which is the one that is checked."""
    from drivegate_cases.requirements.file import RequirementsFile

    schema, scenario = _of(RequirementsFile, "requirements"), _scenario()
    definitions = scenario.pop("$defs")
    for key in ("drive", "schema"):
        scenario["properties"].pop(key)
    scenario["required"] = [key for key in scenario["required"] if key in scenario["properties"]]
    entry = {key: value for key, value in scenario.items() if key not in ("$schema", "title")}
    schema["properties"]["scenario"]["items"] = _with_ranges(entry)
    schema["$defs"] |= _with_ranges(definitions)
    return schema


def _with_ranges(schema: Any) -> Any:
    """Let every number of a schema also be a range [low, high]."""
    if isinstance(schema, list):
        return [_with_ranges(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") in ("number", "integer"):
        number = {"type": "number"}
        either = [schema, {"type": "array", "items": number, "minItems": 2, "maxItems": 2}]
        return {"anyOf": either} | {key: schema[key] for key in ("description",) if key in schema}
    return {key: _with_ranges(value) for key, value in schema.items()}


SCHEMAS: Final[Mapping[str, Callable[[], Schema]]] = MappingProxyType(
    {
        "drive": _drive,
        "scenario": _scenario,
        "candidate": _candidate,
        "campaign": _campaign,
        "waivers": _waivers,
        "requirements": _requirements,
    }
)
"""What makes each, by the kind of file."""


def schema_file(name: str) -> str:
    """Name the file of a schema."""
    return f"{name}.schema.json"


def schema_line(name: str) -> str:
    """Return the first line of a file, by which editors find its schema."""
    return f"#:schema {FOLDER}/{schema_file(name)}"


def schema_contents(*names: str) -> dict[str, bytes]:
    """Return the schemas that files name in their first line, by their places next to these."""
    return {
        f"{FOLDER}/{schema_file(name)}": f"{json.dumps(SCHEMAS[name](), indent=1)}\n".encode()
        for name in names
    }


def write_missing(name: str, folder: Path) -> None:
    """Write the schema that a new file in a folder names, unless there is one already."""
    for place, content in schema_contents(name).items():
        target = folder / place
        if not target.exists():
            target.parent.mkdir(exist_ok=True)
            write_atomically(target, content)


def _of(model: type[Document], name: str) -> Schema:
    schema = model.model_json_schema(by_alias=True)
    number = model.schema_current
    schema["properties"]["schema"] = {"const": number, "description": "number of the document's schema"}
    schema["required"] = ["schema", *schema.get("required", ())]
    _allow_names(schema["properties"])
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"drivegate {name}, schema {number}",
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _allow_names(properties: Schema) -> None:
    """Add to keys that are tables the names that stand for one."""
    if "drive" in properties:
        stated = properties["drive"]
        properties["drive"] = {
            "anyOf": [{"type": "string"}, {"type": "object"}],
            **{key: stated[key] for key in ("description", "default") if key in stated},
        }
