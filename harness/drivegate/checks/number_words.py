"""Shares and powers as the texts of checks write them."""

from __future__ import annotations

import math
from typing import Final

from drivegate.scenarios.drive_scale import tidy

_KILO: Final = 1000.0


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
