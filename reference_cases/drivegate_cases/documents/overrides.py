"""Reading ``KEY=VALUE`` pairs, by which single values of a document are set from a command line."""

import json
from collections.abc import Collection, Sequence
from typing import Any

from drivegate_cases.documents.extent import excess_of
from drivegate_cases.documents.wording import nearest, short_line, shown
from drivegate_models.errors import InputError


def parse_overrides(pairs: Sequence[str], known: Collection[str]) -> dict[str, Any]:
    """Read pairs of key and value."""
    values: dict[str, Any] = {}
    for pair in pairs:
        key, equals, text = (part.strip() for part in pair.partition("="))
        if not equals or not key or not text:
            raise InputError(f"--set {shown(pair)} is not a setting, which is written KEY=VALUE")
        if key not in known:
            raise InputError(
                f"--set {short_line(pair)}: the key '{short_line(key)}' is unknown, "
                f"the nearest known key is '{nearest(key, known)}'"
            )
        values[key] = _value(text)
        excess = excess_of(values[key])
        if excess:
            raise InputError(f"--set {key}: the value {excess}")
    return values


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        pass
    try:
        return float(text)
    except ValueError:
        return text
