"""Measure at which effort each kind of fault is caught: ``python benchmarks/kinds_of_faults.py pm-ac-interior``.

For each kind of operation, with its faulty controllers, the table has the run that catches each, and at which efforts.
A fixed run is the same at every effort and with every seed. What no fixed run shows is searched for with every seed,
first at effort quick, then at default. With ``--drawn`` the fixed runs are left out: what would drawing alone catch?
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.catalogue import contract_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.selftest.matrix import FaultRow
from drivegate_lab.selftest.operations import operations
from drivegate_lab.selftest.run import SelftestEffort, try_faults
from drivegate_lab.selftest.subjects import FAULTS_OF

EFFORTS = ("quick", "default")


def measured(faults: Sequence[SeededFault], effort: SelftestEffort) -> dict[str, list[FaultRow]]:
    """Try faults at one effort after the other, each until an effort catches it with every seed."""
    rows: dict[str, list[FaultRow]] = {fault.name: [] for fault in faults}
    left = list(faults)
    for name in EFFORTS:
        at = SelftestEffort(
            name, effort.seeds, effort.workers, effort.search, effort.drawn_only, effort.drive
        )
        tried = dict(zip([fault.name for fault in left], try_faults(left, at), strict=True))
        for fault, row in tried.items():
            rows[fault].append(row)
        left = [fault for fault in left if tried[fault.name].applies and not tried[fault.name].caught]
    return rows


def line(rows: Sequence[FaultRow], fixed: Iterable[str]) -> tuple[str, str, str, str]:
    """Return the cells of one fault: its name, its check, the first run that catches it, and with how many seeds."""
    last = rows[-1]
    catches = [catch for row in rows for catch in row.catches.values() if catch is not None]
    if not last.applies:
        return last.name, last.check, "does not apply", "–"
    if not catches:
        return last.name, last.check, "none", "missed"
    run = min(catches, key=lambda catch: catch.runs).scenario
    if run in fixed:
        return last.name, last.check, f"`{run}`", "every effort and seed"
    counts = [
        f"{effort} {len(row.catches) - len(row.missed_seeds)} of {len(row.catches)}"
        for effort, row in zip(EFFORTS, rows, strict=False)
    ]
    return last.name, last.check, f"drawn, such as `{run}`", ", ".join(counts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drive")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--drawn", action="store_true", help="leave the fixed runs out")
    parser.add_argument("--all", action="store_true", help="every faulty controller of the contract")
    given = parser.parse_args()
    drive = load_drive(given.drive)
    effort = SelftestEffort("quick", given.seeds, given.workers, True, given.drawn, drive)
    kinds = {each.kind: each.faults for each in operations(drive)}
    if given.all:
        for fault in FAULTS_OF[drive.contract].values():
            if not any(fault in faults for faults in kinds.values()):
                kinds[fault.kind] = (*kinds.get(fault.kind, ()), fault)
    faults = list({fault.name: fault for faults in kinds.values() for fault in faults}.values())
    rows = measured(faults, effort)
    fixed = (
        set()
        if given.drawn
        else {run.name for run in contract_of(drive).fixed_scenarios(drive, NOTHING_DECLARED)}
    )
    write = sys.stdout.write
    write(f"{given.seeds} seeds\n\n| kind | faulty controller | check | caught in | caught at |\n")
    write("|---|---|---|---|---|\n")
    for kind, members in kinds.items():
        for fault in members:
            name, check, run, caught = line(rows[fault.name], fixed)
            write(f"| {kind} | `{name}` | {check} | {run} | {caught} |\n")


if __name__ == "__main__":
    main()
