"""How often the likely cause of a seeded fault is named: ``python benchmarks/likely_causes.py [DRIVE ...]``.

Each faulty controller of duty ratios runs through the fixed scenarios of a drive. What it fails is what the causes are
looked up by, as after `drivegate check`; the foremost causes that are named are compared with the one that the table
states for the fault.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from typing import Any

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.likely_causes import LIKELY_CAUSES, LikelyCause, likely_causes, signs_of
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS


def failed_checks(name: str, drive: DriveDocument) -> list[dict[str, Any]]:
    """Return the checks that a faulty controller fails in the fixed scenarios, each with its worst measured value."""
    contract, loaded = contract_of(drive), own_candidate(resolve_candidate(f"faulty:{name}"))
    declaration = loaded.candidate.declaration
    worst: dict[str, Any] = {}
    for scenario in contract.fixed_scenarios(drive, declaration):
        record = recorded(loaded, scenario, loaded.controller())
        for check in contract.checks:
            margin = None
            if check.reason_not_applicable(declaration, drive) is None:
                margin = check.evaluate(record)
            if margin is not None and not margin.advisory and not margin.met:
                known = worst.get(check.id)
                worst[check.id] = margin if known is None or margin.value < known.value else known
    return [{"id": check, "measured": margin.measured} for check, margin in worst.items()]


def rows(drive: DriveDocument) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Run every faulty controller that fails anything."""
    for name in DUTY_FAULTS:
        failed = failed_checks(name, drive)
        if failed:
            yield name, failed


def counted(failures: Mapping[str, list[dict[str, Any]]]) -> tuple[int, int, int]:
    """Count faults, those whose cause is named first, and those whose cause is named at all."""
    right = {name: cause for cause in LIKELY_CAUSES for name in cause.faults}
    named = {name: _named(failed) for name, failed in failures.items()}
    first = sum(causes[:1] == (right.get(name),) for name, causes in named.items())
    return len(failures), first, sum(right.get(name) in causes for name, causes in named.items())


def _named(failed: list[dict[str, Any]]) -> tuple[LikelyCause, ...]:
    return tuple(cause for cause, _ in likely_causes(failed))


def main(names: list[str]) -> None:
    """Print what each fault fails, what is named, and how often it is right."""
    for drive in map(load_drive, names or ["pm-ac-interior", "pm-ac-surface"]):
        failures = dict(rows(drive))
        for name, failed in failures.items():
            causes = "; ".join(cause.words for cause in _named(failed)) or "none"
            sys.stdout.write(f"{name}: {' '.join(sorted(signs_of(failed)))} -> {causes}\n")
        faults, first, any_of_two = counted(failures)
        counts = {"drive": drive.name, "faults": faults, "named_first": first, "named": any_of_two}
        sys.stdout.write(f"{json.dumps(counts)}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
