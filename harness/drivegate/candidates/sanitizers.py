"""The sanitizers that can look into a candidate, and what they report."""

from __future__ import annotations

from typing import Final

from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

SANITIZERS: Final = ("address", "undefined", "float")
"""Memory; what the language leaves undefined, with conversions of floats that are out of range; floats divided by 0."""


def read_sanitizers(text: str) -> tuple[str, ...]:
    """Read names with commas between them."""
    names = tuple(dict.fromkeys(word.strip() for word in text.split(",")))
    unknown = [name for name in names if name not in SANITIZERS]
    if unknown:
        raise InputError(
            f"--sanitize names '{one_line(unknown[0])}', the nearest known one is "
            f"'{nearest(unknown[0], SANITIZERS)}'; known are {', '.join(SANITIZERS)}"
        )
    return names
