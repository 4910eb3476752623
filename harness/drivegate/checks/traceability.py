"""Which runs exercise which check, and which check holds which fact of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from drivegate.checks.catalogue import CHECKS_OF
from drivegate.checks.check import Check
from drivegate.checks.drive_numbers import on_drive
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.publication.facts import Fact, facts

EVERY_RUN: Final = ("PWR-1", "PWR-2", "NEU-1", "ADV-2", "CMD-1", "CUR-1")
"""Checks that judge every run in the closed loop."""
FIXED: Final = "fixed"
"""Name of the scenarios that are run first, whatever the seed; they exercise all checks but those of `SPECIAL`."""
DRAWN: Final[Mapping[str, tuple[str, ...]]] = {
    "steady": ("CNV-1", "CNV-2", "RIP-3", "TRQ-1"),
    "constant power": ("CNV-1", "CNV-2", "CPW-1", "RIP-2", "RIP-3", "TRQ-1"),
    "required point": ("CNV-1", "CNV-2", "CNV-3", "RIP-1", "RIP-3", "TRQ-1"),
    "parameter": ("ROB-1",),
    "load step": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "load course": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "sensor": ("ROB-2",),
    "phase": ("ROB-2", "ROB-3"),
    "supply": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "beginning": ("CNV-1", "CNV-2", "RIP-3", "TRQ-1"),
    "fault": ("ROB-3",),
    "restart": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "speed step": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "standstill": ("ADV-1", "CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "base speed": ("ADV-1",),
    "overspeed": ("CNV-1", "CNV-2", "CPW-2", "RIP-3", "TRQ-1"),
    "vehicle": ("CNV-2", "CNV-3", "RIP-3"),
}
"""For each family of `scenarios.drawn`, the checks that it is there for, beside those of every run."""
DUTY_EVERY_RUN: Final = ("PWR-1", "DUT-1", "OVC-1")
"""Checks that judge every run of a controller of duty ratios."""
DUTY_DRAWN: Final[Mapping[str, tuple[str, ...]]] = {
    "torque step": ("ACC-1", "STP-1", "DEC-1", "RIP-4", "DTM-1", "FWK-2", "FWK-3", "MTP-1"),
    "weakening": ("FWK-1", "FWK-2", "FWK-3"),
    "speed step": ("ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "load step": ("ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "start": ("STA-1", "ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "parameter": ("ROB-4",),
    "supply step": ("ACC-1", "FWK-2", "MTP-1"),
    "sensor": ("ROB-5",),
    "failure": ("SAF-1",),
}
"""For each family of `scenarios.duty.drawn`, the checks that it is there for, beside those of every run."""
SPECIAL: Final[Mapping[str, tuple[str, ...]]] = {
    "repetition": ("DET-1",),
    "timing": ("TIM-1",),
    "script": ("FLO-1",),
}
"""Checks that are judged on runs of their own kind."""


def family_name(function_name: str) -> str:
    """Name a family as people read it."""
    return function_name.removesuffix("_scenarios").replace("_", " ")


def families_of(check: str, contract: str = "current") -> tuple[str, ...]:
    """List the kinds of runs that exercise a check of a contract."""
    special = tuple(kind for kind, checks in SPECIAL.items() if check in checks)
    families, every = (DUTY_DRAWN, DUTY_EVERY_RUN) if contract == "duty" else (DRAWN, EVERY_RUN)
    drawn = tuple(family for family, checks in families.items() if check in (*every, *checks))
    return special or (FIXED, *drawn)


def facts_of(check: Check) -> tuple[Fact, ...]:
    """List the facts that a check rests on."""
    named = check.source.split(", ")
    return tuple(fact for fact in facts() if fact.id in named)


def traced_checks(drive: DriveDocument) -> list[dict[str, Any]]:
    """Write down every check, with the numbers of a drive, what it rests on and what exercises it."""
    keys = ("id", "requirement", "source", "subject", "level", "limit", "formula", "why", "scenarios")
    return [
        {key: getattr(check, key) for key in keys}
        | {
            "families": list(families_of(check.id, drive.contract)),
            "facts": [{"id": fact.id, "title": fact.title, "where": fact.source} for fact in facts_of(check)],
        }
        for check in (on_drive(listed, drive) for listed in CHECKS_OF[drive.contract])
    ]


def traced_facts() -> list[dict[str, Any]]:
    """Write down every fact with what covers it."""
    return [
        {"id": fact.id, "title": fact.title, "where": fact.source}
        | {"covered_by": fact.covered_by.model_dump(mode="json")}
        for fact in facts()
    ]
