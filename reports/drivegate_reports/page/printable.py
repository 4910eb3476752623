"""Any text of a candidate made printable and bounded; escaping for HTML is the template's."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

LONGEST_TEXT: Final = 2_000
"""Longest text of a cell (characters)."""
LONGEST_BLOCK: Final = 20_000
"""Longest scenario or traceback (characters)."""


def clean(value: object, longest: int = LONGEST_TEXT) -> str:
    """Make any text printable and bounded; line ends are kept."""
    text = str(value)[: longest + 1]
    shown = "".join(
        character
        if character == "\n" or character.isprintable()
        else character.encode("unicode_escape").decode("ascii")
        for character in text
    )
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def plain_number(value: float, digits: int = 3) -> str:
    """Write a number with its sign and never in powers of ten: people read −399, not −4e+02."""
    text = f"{value:+.{digits}g}"
    return (f"{value:+.0f}" if "e" in text else text).replace("-", "−")


def plain_data(value: object, indent: int = 0) -> str:
    """Write plain data so that it reads well: a line for each key, lists on one line."""
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, ensure_ascii=False, default=str)
    lines = []
    for key, item in value.items():
        nested = isinstance(item, Mapping) and bool(item)
        written = plain_data(item, indent + 1)
        lines.append(f"{'  ' * indent}{key}:{chr(10) if nested else ' '}{written}")
    return "\n".join(lines)
