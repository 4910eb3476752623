"""One field of two commands side by side."""

from __future__ import annotations

import struct
from math import isfinite
from typing import Any


def number_field(name: str, unit: str, first: float, second: float, *, differs: bool) -> dict[str, Any]:
    """Write a number of both as plain data, to the last bit."""
    one_bits, other_bits = (bits_of(number) for number in (first, second))
    return {
        "field": name,
        "unit": unit,
        "first": first,
        "second": second,
        "first_bits": f"{one_bits & 0xFFFF_FFFF_FFFF_FFFF:016x}",
        "second_bits": f"{other_bits & 0xFFFF_FFFF_FFFF_FFFF:016x}",
        "difference": second - first,
        "ulps": units_in_the_last_place(first, second),
        "differs": differs,
    }


def whole_field(name: str, unit: str, first: int, second: int, *, differs: bool) -> dict[str, Any]:
    """Write a whole number of both as plain data."""
    both = {"first": first, "second": second, "first_bits": None, "second_bits": None}
    return {
        "field": name,
        "unit": unit,
        **both,
        "difference": second - first,
        "ulps": None,
        "differs": differs,
    }


def bits_of(number: float) -> int:
    """Return the bits of a double."""
    return int.from_bytes(struct.pack("<d", number), "little", signed=True)


def in_words(field: dict[str, Any]) -> str:
    """Describe how far apart two numbers are."""
    first, second = field["first"], field["second"]
    if field["ulps"] is None and isinstance(first, int):
        return f"{field['difference']:+d}" if field["difference"] else ""
    if field["ulps"] is None:
        neither = not isfinite(first) and not isfinite(second)
        return "" if neither else "one of them makes none"
    if field["ulps"] == 0:
        return "" if field["first_bits"] == field["second_bits"] else "the sign of zero"
    return f"{field['difference']:+.3g} ({field['ulps']} ULP)"


def units_in_the_last_place(one: float, other: float) -> int | None:
    """Count the doubles from one number to another."""
    if not (isfinite(one) and isfinite(other)):
        return None
    return abs(_place(one) - _place(other))


def _place(number: float) -> int:
    """Return the place of a double on the line of all doubles, zero at zero."""
    bits = bits_of(number)
    return bits if bits >= 0 else -(bits & 0x7FFF_FFFF_FFFF_FFFF)
