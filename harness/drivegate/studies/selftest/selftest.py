"""The whole self-test: the faulty controllers that are requested, and every correct design."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from drivegate.output.event_loop import finished
from drivegate.output.progress import progress_on

if TYPE_CHECKING:
    from drivegate.studies.selftest.detection import FaultRow
    from drivegate.studies.selftest.matrix import DesignRow, Matrix
    from drivegate.studies.selftest.run import SelftestEffort
    from drivegate.studies.selftest.seeded_fault import SeededFault

TITLE = "faulty controllers"


def chosen_names(names: Sequence[str], kind: str) -> tuple[str, ...]:
    """Find faulty controllers for drives of a kind by their names; without any, all."""
    from drivegate.drives.kinds import DRIVE_KINDS
    from drivegate.studies.selftest.seeded_fault import chosen_faults
    from drivegate_cases.drive.drive_document import load_drive

    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    return tuple(fault.name for fault in chosen_faults(names, drive))


def selftested(names: Sequence[str], effort: SelftestEffort, *, designs: bool) -> Matrix:
    """Put faulty controllers before the checks, all of them without names, and correct designs if requested."""
    from drivegate.contracts.catalogue import contract_of
    from drivegate.drives.choice import drive_for
    from drivegate.studies.selftest.matrix import Matrix
    from drivegate.studies.selftest.seeded_fault import chosen_faults

    drive = drive_for(None, effort.drive)
    rows = _tried(chosen_faults(names, drive), effort)
    judged = _judged(drive.contract, effort) if designs else ()
    return Matrix(tuple(check.id for check in contract_of(drive).checks()), rows, judged)


def _tried(faults: Sequence[SeededFault], effort: SelftestEffort) -> tuple[FaultRow, ...]:
    # It brings the compiled plant, which a name that is refused does not need.
    from drivegate.studies.selftest.run import try_faults

    rows: list[FaultRow] = []
    with progress_on(sys.stderr) as display:
        display.begin(TITLE, len(faults))
        for row in try_faults(faults, effort):
            rows.append(row)
            # Each line tells of another controller, so none is left out.
            display.advance(len(rows), len(faults), in_short(row), always=True)
    return tuple(rows)


def _judged(contract: str, effort: SelftestEffort) -> tuple[DesignRow, ...]:
    from drivegate.studies.selftest.correct_designs import correct_designs
    from drivegate.studies.selftest.run import design_check, judged_design

    rows = []
    for design in correct_designs(contract):
        for seed in range(effort.seeds):
            with progress_on(sys.stderr) as display:
                result = finished(design_check(design, seed, effort), display)
            rows.append(judged_design(design, result))
    return tuple(rows)


def in_short(row: FaultRow) -> str:
    """Tell in a few words what has become of a faulty controller."""
    slowest = row.slowest
    if not row.applies:
        return f"{row.name}: does not apply"
    if slowest is None:
        return f"{row.name}: missed by {row.check} in {row.runs} runs"
    return f"{row.name}: caught by {row.check} in run {slowest.runs}"
