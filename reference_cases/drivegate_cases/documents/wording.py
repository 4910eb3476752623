"""Turning names, numbers, values and paths of a user's files into words that fit on one line of a message."""

import difflib
import json
import re
from collections.abc import Iterable
from math import floor
from pathlib import Path
from typing import Final

_DIGITS: Final = 3
_ROUNDING: Final = 1e-9
_SMALLEST: Final = 1e-300
LONGEST_MESSAGE: Final = 400
"""Most characters of an error message."""
_LONGEST_VALUE: Final = 60
_LONGEST_PATH: Final = 160
_FEW: Final = 12
"""Number of names that fit into a sentence."""
_RESEMBLES: Final = 0.5
"""Share of letters in order from which on a name may be a misspelt one (1)."""
_LONGEST_COMPARED: Final = 100
_LARGE: Final = 10000.0
_COMMA_NUMBER: Final = re.compile(r"[+-]?\d[\d.]*,\d+(?:[eE][+-]?\d+)?")


def significant(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def decimal_exponent(value: float) -> int:
    """Return the power of ten of a number's first digit, without a logarithm, which differs between processors."""
    return int(f"{value:.17e}".partition("e")[2])


def rounded_to_digits(value: float, *, up: bool) -> float:
    """Round to three digits, up or down; 0 for one that is not above it."""
    if not value > _SMALLEST:
        return 0.0
    unit = float(f"1e{decimal_exponent(value) - _DIGITS + 1}")
    whole = floor(value / unit * (1.0 + (-_ROUNDING if up else _ROUNDING))) + (1 if up else 0)
    return significant(whole * unit, _DIGITS)


def nearest(name: str, known: Iterable[str], least: float = 0.0) -> str | None:
    """Find the known name that resembles a given one most, by at least a share of their letters."""
    by_lower_case = {candidate.lower(): candidate for candidate in known}
    compared = shortened(name, _LONGEST_COMPARED).lower()
    closest = difflib.get_close_matches(compared, sorted(by_lower_case), n=1, cutoff=least)
    return by_lower_case[closest[0]] if closest else None


def nearest_key(name: str, known: Iterable[str]) -> str:
    """State the known key that was probably meant, or what is known where none resembles the given one."""
    names = list(known)
    closest = nearest(name, names, _RESEMBLES)
    if closest is not None:
        return f"the nearest known key is '{closest}'"
    if len(names) > _FEW:
        return "and no known key resembles it"
    return f"known are {', '.join(names)}" if names else "no key is known there"


def counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def figure(value: float) -> str:
    """Write a number with four digits, or with all of those before the point."""
    return f"{value:.4g}" if not abs(value) >= _LARGE else f"{value:.0f}"


def with_point(text: str) -> str | None:
    """Write a number with a decimal comma as one with a point; None for any other text."""
    number = text.strip()
    if not _COMMA_NUMBER.fullmatch(number):
        return None
    return number.replace(".", "").replace(",", ".")


def pointed(text: str) -> str:
    """Return what a sentence about a number adds for a decimal comma; empty for any other text."""
    right = with_point(text)
    return f" with a decimal point, {right}" if right else ""


def one_line(text: str) -> str:
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode("ascii")
        for character in text
    )


def shortened(text: str, longest: int) -> str:
    """Cut the middle out of a long text, since its start and its end say most about it."""
    if len(text) <= longest:
        return text
    end = (longest - 1) // 2
    return f"{text[: longest - 1 - end]}…{text[len(text) - end :]}"


def short_line(text: str, longest: int = _LONGEST_VALUE) -> str:
    # Of a very long text only the ends are made printable, and escapes may make them longer.
    return shortened(one_line(shortened(text, longest)), longest)


def shown(value: object) -> str:
    """Write a value of a document the way the document would, shortened where it is long."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and not isinstance(value, bool) and value.bit_length() > 128:
        return f"an integer of {value.bit_length()} bits"
    return short_line(json.dumps(value, ensure_ascii=False, default=str))


def shown_path(path: str | Path) -> str:
    return short_line(str(path), _LONGEST_PATH) or "''"
