"""Print the worst residual of the shaft's ledger over all fixed scenarios of drives.

    python benchmarks/shaft_ledger.py                      # all included drives
    python benchmarks/shaft_ledger.py pm-ac-interior my-drive.toml

A row has the number of runs with a free shaft, the worst share of the throughput that a control period or a run misses,
the run in which that is, and the works of all runs by kind in joules. The controller is the usual one of the drive's
contract. The exit code is 3 if a residual exceeds 1e-9.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import Any, Final, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import kind_of
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_models.machine import shaft_ledger

TOLERANCE: Final = 1e-9
"""Greatest share of the throughput that may be missing (1)."""
_AT_ONCE: Final = 2
_KINDS: Final = ("MACHINE", *shaft_ledger.OPPOSING, "HOIST", "GRADE", "BROUGHT", "STOPPED")


class Residual(NamedTuple):
    """The ledgers of a drive's runs."""

    drive: str
    runs: int
    """Runs whose shaft is free, at least at first."""
    worst: float
    """Greatest residual over the throughput (1)."""
    where: str
    """Name of its scenario."""
    works: NDArray[np.float64]
    """Sum of the ledgers, shape (shaft_ledger.ENTRIES,) (J)."""


def residual_of(name: str) -> Residual:
    """Run the usual controller through all fixed scenarios of a drive."""
    drive = load_drive(name)
    contract = contract_of(drive)
    prepare = kind_of(drive).prepare_loop()
    controller = load_controller(resolve_candidate(contract.usual_candidate))
    found = Residual(drive.name, 0, 0.0, "", np.zeros(shaft_ledger.ENTRIES))
    for scenario in contract.fixed_scenarios(drive, NOTHING_DECLARED):
        run: Any = contract.record(prepare, NOTHING_DECLARED, scenario, controller).run
        if run.shaft[shaft_ledger.INERTIA] == 0.0:
            continue
        error = shaft_ledger.shaft_error(run.shaft)
        worst, where = max((error, scenario.name), (found.worst, found.where))
        found = Residual(drive.name, found.runs + 1, worst, where, found.works + run.shaft)
    return found


def lines(found: Residual) -> Iterator[str]:
    """Describe the ledgers of a drive."""
    yield f"{found.drive}: {found.runs} runs, worst residual {found.worst:.1e} ({found.where})"
    works = {kind: float(found.works[getattr(shaft_ledger, kind)]) for kind in _KINDS}
    yield "  " + ", ".join(f"{kind.lower()} {work:.4g} J" for kind, work in works.items() if work)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("drives", nargs="*", help="names or files of drives, by default all included ones")
    names = parser.parse_args().drives or list(drive_names())
    worst = 0.0
    for found in Parallel(n_jobs=_AT_ONCE, return_as="generator")(
        delayed(residual_of)(name) for name in names
    ):
        sys.stdout.write("".join(f"{line}\n" for line in lines(found)))
        sys.stdout.flush()
        worst = max(worst, found.worst)
    sys.stdout.write(f"worst of all: {worst:.1e}\n")
    return 0 if worst <= TOLERANCE else 3


if __name__ == "__main__":
    raise SystemExit(main())
