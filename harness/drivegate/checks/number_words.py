"""Limits, shares and powers as the texts of checks write them."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any, Final

from drivegate.scenarios.drive_scale import tidy

_KILO: Final = 1000.0
_UNITS: Final = {"_nm": " N·m", "_a": " A", "_s": " s", "_rpm": " rpm", "_deg": "°"}


def limit_words(limits: Any) -> dict[str, str]:
    """Write each number of a drive's limits, by its field without the unit that ends it; one without is a share."""
    numbers = {name: value for name, value in asdict(limits).items() if isinstance(value, float)}
    return dict(_limit_in_words(name, value) for name, value in numbers.items())


def _limit_in_words(name: str, value: float) -> tuple[str, str]:
    found = next((end for end in _UNITS if name.endswith(end)), "")
    return name.removesuffix(found), f"{value:.4g}{_UNITS[found]}" if found else percent(value)


def percent(share: float) -> str:
    """Write a share as a percentage."""
    if math.isinf(share):
        return "no limit"
    return f"{tidy(100.0 * share):g} %"


def power(watts: float) -> str:
    """Write a power in watts or kilowatts."""
    return f"{watts / _KILO:g} kW" if watts >= _KILO else f"{watts:g} W"


def milliseconds(time_s: float) -> str:
    """Write a time in milliseconds."""
    return f"{tidy(_KILO * time_s):g} ms"
