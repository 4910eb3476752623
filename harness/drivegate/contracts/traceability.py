"""Which runs exercise which check, and which check holds which fact of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.checks.check import Check
from drivegate.contracts.catalogue import check_of, checks_of, contract_named, on_drive
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.publication import Fact, facts

FIXED: Final = "fixed"
"""Name of the scenarios that are run first, whatever the seed; they exercise all checks but those of `SPECIAL`."""
SPECIAL: Final[Mapping[str, tuple[str, ...]]] = {
    "repetition": ("DET-1",),
    "timing": ("TIM-1",),
    "script": ("FLO-1",),
}
"""Checks that are judged on runs of their own kind."""


def family_name(function_name: str) -> str:
    """Name a family as people read it."""
    return function_name.removesuffix("_scenarios").replace("_", " ")


def families_of(
    check: str, contract: str = "current", declaration: Declaration = NOTHING_DECLARED
) -> tuple[str, ...]:
    """List the kinds of runs that exercise a check of a contract, or a row."""
    special = tuple(kind for kind, checks in SPECIAL.items() if check in checks)
    found, drawn = check_of(contract, check, declaration), contract_named(contract).families
    return special or (FIXED, *(name for name in drawn if found.every_run or name in found.families))


def facts_of(check: Check) -> tuple[Fact, ...]:
    named = check.source.split(", ")
    return tuple(fact for fact in facts() if fact.id in named)


def traced_checks(drive: DriveDocument, declaration: Declaration = NOTHING_DECLARED) -> list[dict[str, Any]]:
    """Write down every check and row, with the numbers of a drive, what it is based on and what exercises it."""
    keys = ("id", "requirement", "source", "subject", "level", "limit", "formula", "why", "scenarios")
    return [
        {key: getattr(check, key) for key in keys}
        | {
            "families": list(families_of(check.id, drive.contract, declaration)),
            "facts": [_in_short(fact) for fact in facts_of(check)],
        }
        for check in (on_drive(listed, drive) for listed in checks_of(drive, declaration))
    ]


def traced_facts() -> list[dict[str, Any]]:
    """Write down every fact with what covers it."""
    return [_in_short(fact) | {"covered_by": fact.covered_by.model_dump(mode="json")} for fact in facts()]


def _in_short(fact: Fact) -> dict[str, Any]:
    return {"id": fact.id, "title": fact.title, "where": fact.source}
