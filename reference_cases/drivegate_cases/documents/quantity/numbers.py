"""Numbers as data sheets print them: decimal commas, separators of thousands and powers of ten."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

_GROUPED: Final = re.compile(r"\d{1,3}(?P<by>[.,])\d{3}(?:(?P=by)\d{3})+")
_GROUPED_DECIMAL: Final = re.compile(r"\d{1,3}(?:,\d{3})+\.\d+|\d{1,3}(?:\.\d{3})+,\d+")
_EITHER: Final = re.compile(r"[1-9]\d{0,2}[.,]\d{3}")
_POWER: Final = r"10\s*(?:(?:\^|\*\*)\s*\(?[+-]?|[+-])\d{1,2}(?!\d)\)?"
_DIGITS: Final = r"\d{1,3}(?:[ ']\d{3})+(?!\d)(?:[.,]\d+)?|\d[\d.,]*|[.,]\d+"
_NUMBER: Final = re.compile(
    rf"(?P<bare>{_POWER})|(?P<digits>{_DIGITS})(?P<exponent>\s?[eE][+-]?\d+)?(?:\s*[x×·*]?\s*(?P<power>{_POWER}))?"
)
_POWER_AFTER: Final = re.compile(
    rf"\s*\(?\s*(?:[x×·*.]\s*)?(?P<power>{_POWER}|(?<=[\s*·x×])1?[eE]-\d{{1,2}})\s*\)?\s*$"
)
_GROUPS: Final = str.maketrans("", "", " '")


@dataclass(frozen=True)
class Number:
    """A number, and what else its digits may mean."""

    value: float
    digits: str = ""
    """The digits as they were written."""
    grouped: float | None = None
    """The number if its separator is one of thousands, where that is possible; otherwise none."""

    @property
    def is_open(self) -> bool:
        """Whether a comma may be a decimal one or one of thousands; of a point the unit decides."""
        return self.grouped is not None and "," in self.digits


def leading_number(text: str) -> tuple[Number, str] | None:
    """Read the number that a text begins with, and return it with the rest; none if it begins with none."""
    found = _NUMBER.match(text)
    if found is None:
        return None
    rest = text[found.end() :]
    if found["bare"]:
        return Number(_power(found["bare"])), rest
    digits = found["digits"].translate(_GROUPS)
    value = _value(digits)
    if value is None:
        return None
    # Python reads "1e-4" itself, so that it rounds once.
    exponent = (found["exponent"] or "").strip()
    if found["power"]:
        exponent = f"e{_exponent(found['power'])}" if not exponent else ""
    is_either = _EITHER.fullmatch(digits) is not None and not exponent
    grouped = float(digits.replace(",", "").replace(".", "")) if is_either else None
    return Number(float(f"{value}{exponent}"), digits, grouped), rest


def without_power(unit: str) -> tuple[str, int]:
    """Take a negative power of ten off the end of a unit, as of a column headed kg·m² × 10⁻⁴."""
    found = _POWER_AFTER.search(unit)
    if found is None or _exponent(found["power"]) >= 0:
        return unit, 0
    return unit[: found.start()], _exponent(found["power"])


def scaled(number: Number, exponent: int) -> Number:
    """Multiply a number by a power of ten."""
    return Number(float(f"{number.value!r}e{exponent}")) if exponent else number


def _value(digits: str) -> str | None:
    """Return digits with a decimal point alone; none where the separators make no number."""
    if _GROUPED.fullmatch(digits):
        return digits.replace(".", "").replace(",", "")
    if _GROUPED_DECIMAL.fullmatch(digits):
        decimal = max(digits.rfind("."), digits.rfind(","))
        return f"{digits[:decimal].replace('.', '').replace(',', '')}.{digits[decimal + 1 :]}"
    plain = digits.replace(",", ".")
    return plain if plain.count(".") <= 1 and not digits.endswith(",") else None


def _power(text: str) -> float:
    return float(f"1e{_exponent(text)}")


def _exponent(text: str) -> int:
    return int(re.sub(r"^(?:10|1?[eE])|[\s^*()]", "", text))
