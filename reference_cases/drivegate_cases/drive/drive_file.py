"""The file of a drive: TOML with a comment for each key, and the JSON Schema that editors hold it to."""

from __future__ import annotations

import json
from collections.abc import Container, Iterator
from typing import Any

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.data_sheet import following
from drivegate_cases.drive.drive_document import PM_AC, DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument

_WIDTH = 40


def drive_toml(drive: DriveDocument) -> str:
    """Write a drive as TOML: every key with its meaning; one without a value, or that follows, is a comment."""
    omitted = following(drive)
    head = ("name", "kind")
    lines = [
        "#:schema schemas/drive.schema.json",
        "# A drive for drivegate. Every value is nominal; change what is not yours, and say where yours is from.",
        "schema = 1",
        *(_line(type(drive), key, getattr(drive, key)) for key in head),
    ]
    for name, model in drive.tables.items():
        described = type(drive).model_fields[name].description
        lines += ["", *_table(name, model, getattr(drive, name), described, omitted)]
    lines += ["", "[provenance]  # where each value comes from, in a sentence"]
    for name, sentences in drive.provenance.items():
        lines += [
            f"{name}.{key} = {toml_value(sentence)}"
            for key, sentence in sentences.items()
            if key not in omitted
        ]
    return "\n".join(lines) + "\n"


def drive_schema() -> dict[str, Any]:
    """Make the JSON Schema of the document, whose tables are others for PM AC drives."""
    others, pm_ac = _schema_of(DriveDocument), _schema_of(PmAcDocument)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "drivegate drive, schema 1",
        "$defs": others.pop("$defs") | pm_ac.pop("$defs"),
        "if": {"properties": {"kind": {"const": PM_AC}}},
        "then": pm_ac,
        "else": others,
    }


def _schema_of(document: type[DriveDocument]) -> dict[str, Any]:
    schema = document.model_json_schema(by_alias=True)
    schema["properties"]["schema"] = {"const": 1, "description": "number of the document's schema"}
    schema["required"] = ["schema", *schema["required"]]
    return {key: value for key, value in schema.items() if key != "title"}


def _table(
    name: str, model: type[Section], table: Section | None, description: str | None, omitted: Container[str]
) -> Iterator[str]:
    if table is None:
        yield f"# {f'[{name}]':<{_WIDTH}}# {description}; may be left out"
    else:
        yield f"[{name}]"
    for key in model.model_fields:
        value = None if table is None or key in omitted else table.model_dump(mode="json")[key]
        yield _line(model, key, value)


def _line(model: type[Section], key: str, value: Any) -> str:
    """Write a key with its comment; one without a value as a comment altogether."""
    description = model.model_fields[key].description
    if value is None or value == []:
        return f"# {f'{key} =':<{_WIDTH}}# {description}"
    return f"{f'{key} = {toml_value(value)}':<{_WIDTH}}  # {description}"


def toml_value(value: Any) -> str:
    """Write a value as TOML: as JSON, but for tables."""
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {toml_value(item)}' for key, item in value.items())} }}"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
