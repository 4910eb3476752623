"""Limits, shares and powers as the texts of checks write them."""

from __future__ import annotations

import math
from typing import Final

from drivegate.scenarios.drive_scale import tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import Limit, declared_limits

_KILO: Final = 1000.0
_UNITS: Final = {"_nm": " N·m", "_a": " A", "_s": " s", "_rpm": " rpm", "_deg": "°"}


def limit_words(drive: DriveDocument) -> dict[str, str]:
    """Write each limit of a drive, by its name in texts: as its key states it, or else with its unit or in percent."""
    return dict(_limit_in_words(drive, key, limit) for key, limit in declared_limits(drive))


def _limit_in_words(drive: DriveDocument, key: str, limit: Limit) -> tuple[str, str]:
    value = limit.on(drive, key)
    found = next((end for end in _UNITS if limit.name.endswith(end)), "")
    name = limit.in_texts or limit.name.removesuffix(found)
    if key == limit.name:
        return name, f"{value:g}{_UNITS.get(found, '')}"
    return name, f"{value:.4g}{_UNITS[found]}" if found else percent(value)


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
