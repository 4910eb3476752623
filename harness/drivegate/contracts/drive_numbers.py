"""A check with the numbers of a drive in its texts."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Final

from drivegate.checks.check import Check
from drivegate.contracts.catalogue import contract_of
from drivegate_cases.drive.drive_document import DriveDocument

TEXTS: Final = ("requirement", "limit", "scenarios", "formula", "why")
"""Texts of a check that name a drive's numbers."""
_KEPT: Final = 1_000


@lru_cache(maxsize=_KEPT)
def on_drive(check: Check, drive: DriveDocument) -> Check:
    """Return a check whose texts have the numbers of a drive."""
    numbers = contract_of(drive).numbers(drive)
    return replace(check, **{name: getattr(check, name).format_map(numbers) for name in TEXTS})
