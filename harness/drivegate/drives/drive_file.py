"""A drive's document as the text of a TOML file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from drivegate_cases.drive.drive_document import DriveDocument


def drive_toml(drive: DriveDocument) -> str:
    """Write a drive as TOML, the sentences of its provenance last."""
    return "\n".join(_lines(drive.to_mapping())) + "\n"


def _lines(mapping: Mapping[str, Any]) -> Iterator[str]:
    yield from (f"{key} = {_value(value)}" for key, value in mapping.items() if not isinstance(value, dict))
    for name, table in mapping.items():
        if isinstance(table, dict):
            yield ""
            yield f"[{name}]"
            yield from _entries("", table)


def _entries(head: str, table: Mapping[str, Any]) -> Iterator[str]:
    """Write the keys of a table; those of a table in it with its name before them."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _entries(f"{key}.", value)
        elif value != []:
            yield f"{head}{key} = {_value(value)}"


def _value(value: Any) -> str:
    """Write a number, a text or a list, which JSON writes as TOML does."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
