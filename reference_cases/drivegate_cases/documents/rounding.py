"""Numbers rounded to the digits that people write."""

from math import floor
from typing import Final

_DIGITS: Final = 3
_ROUNDING: Final = 1e-9
_SMALLEST: Final = 1e-300


def significant(value: float, digits: int) -> float:
    """Round to significant digits."""
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
