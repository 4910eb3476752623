"""Measure which runs show which faults: ``python benchmarks/fixed_runs.py pm-ac-interior``.

Every faulty controller of the drive's contract goes through every fixed run, and through some runs of each drawn
family, once; through a run that costs more than a second only where no cheaper fixed run shows its fault. From these
results follow the runs that a greedy cover would choose, and for each family the share of faults that a quick check
finds without it. The results of all runs are stored, so that an interrupted measurement goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final, TypeAlias

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))

from varied_keys import drawn_by_family

from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.kinds import FAULTY_PREFIX
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.traceability import FIXED
from drivegate.gate.plan import EXAMPLES, SHARDS
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.selftest.subjects import FAULTS_OF

OF_EACH_FAMILY: Final = 4
"""Drawn runs of each family, unless ``--each`` says otherwise."""
COSTLY_S: Final = 1.0
"""Processor time from which on a run is costly (s)."""
Found: TypeAlias = dict[str, dict[str, list[str]]]
"""For each controller and run the required checks that it fails there."""


def failed_checks(candidate: JudgedCandidate, run: Scenario) -> list[str]:
    """Return the required checks that a candidate fails in a run; ``broken`` where it breaks the contract."""
    try:
        outcome = run_fixed(candidate, FixedRuns((run,), only_fair=True))
    except CandidateFault:
        return ["broken"]
    margins = (margin for judged in outcome.runs for margin in judged.margins)
    return sorted({margin.check for margin in margins if not margin.met and not margin.advisory})


class Store:
    """The checks that each controller fails in each run, in a file."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.found: Found = json.loads(file.read_text()) if file.exists() else {}

    def measure(self, name: str, runs: Mapping[str, Scenario]) -> dict[str, list[str]]:
        """Put a controller through runs, as far as that is not stored yet; return what it fails in all of its runs."""
        known = self.found.setdefault(name, {})
        missing = [key for key in runs if key not in known]
        if missing:
            candidate = own_candidate(resolve_candidate(name))
            known.update({key: failed_checks(candidate, runs[key]) for key in missing})
            self._file.write_text(json.dumps(self.found))
        return known


def shown_in(found: Mapping[str, list[str]], of_base: Mapping[str, list[str]]) -> frozenset[str]:
    """Return the runs in which a controller fails a check that the one without its fault meets."""
    return frozenset(run for run, failed in found.items() if set(failed) - set(of_base.get(run, ())))


def greedy_cover(shown: Mapping[str, frozenset[str]], costs: Mapping[str, float]) -> list[tuple[str, int]]:
    """Choose runs, each time the one that shows most faults that none before it shows; the cheapest of equal ones."""
    left = frozenset[str]().union(*shown.values())
    chosen = []
    while left:
        best = min(shown, key=lambda run: (-len(shown[run] & left), costs[run]))
        chosen.append((best, len(shown[best] & left)))
        left -= shown[best]
    return chosen


def chance(faults: Iterable[str], shares: Mapping[str, Mapping[str, float]], runs_each: float) -> float:
    """Return the expected number of faults that some runs of each family find (1)."""
    expected = 0.0
    for fault in faults:
        missed = 1.0
        for share in shares.values():
            missed *= (1.0 - share.get(fault, 0.0)) ** runs_each
        expected += 1.0 - missed
    return expected


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drive")
    parser.add_argument("--store", type=Path, default=Path("fixed-runs.json"))
    parser.add_argument("--fixed-only", action="store_true")
    parser.add_argument("--each", type=int, default=OF_EACH_FAMILY, help="drawn runs of each family")
    parser.add_argument("--fault", action="append", default=[])
    given = parser.parse_args()
    drive = load_drive(given.drive)
    contract = contract_of(drive)
    base = contract.usual_candidate
    known = {
        f"{FAULTY_PREFIX}{name}": fault
        for name, fault in FAULTS_OF[drive.contract].items()
        if fault.check not in ("FLO-1", "TIM-1", "DET-1")
        and fault.on(drive).idle_because is None
        and (not given.fault or name in given.fault)
    }
    bases = sorted({base, *(fault.base for fault in known.values())})
    fixed = {run.name: run for run in contract.fixed_scenarios(drive, resolve_candidate(base).declaration)}
    costs = timed(own_candidate(resolve_candidate(base)), fixed)
    drawn: dict[str, dict[str, Scenario]] = {}
    if not given.fixed_only:
        for family, scenarios in drawn_by_family(drive).items():
            if family == FIXED:
                continue
            chosen = [run for run in scenarios if contract.unfair_because(run) is None][: given.each]
            drawn[family] = {f"{family} {number}": run for number, run in enumerate(chosen)}
    costly = {key: run for key, run in fixed.items() if costs[key] > COSTLY_S}
    cheap = {key: run for key, run in fixed.items() if key not in costly}
    usual = cheap | {key: run for family in drawn.values() for key, run in family.items()}
    store = Store(given.store)
    of_bases = {name: store.measure(name, usual | costly) for name in bases}
    shown_by = {}
    for name, fault in known.items():
        of_base = of_bases[fault.base]
        shown_by[name] = shown_in(store.measure(name, usual), of_base)
        if not shown_by[name] & cheap.keys():
            shown_by[name] = shown_in(store.measure(name, usual | costly), of_base)

    def shows(run: str) -> frozenset[str]:
        return frozenset(name for name, runs in shown_by.items() if run in runs)

    shown = {run: shows(run) for run in fixed}
    report(known, shown, costs, {family: {run: shows(run) for run in runs} for family, runs in drawn.items()})


def timed(candidate: JudgedCandidate, runs: Mapping[str, Scenario]) -> dict[str, float]:
    """Measure the processor time of each run (s)."""
    failed_checks(candidate, next(iter(runs.values())))
    costs = {}
    for name, run in runs.items():
        begun = time.process_time()
        failed_checks(candidate, run)
        costs[name] = time.process_time() - begun
    return costs


def report(
    known: Mapping[str, object],
    shown: Mapping[str, frozenset[str]],
    costs: Mapping[str, float],
    drawn: Mapping[str, Mapping[str, frozenset[str]]],
) -> None:
    """Print what fixed runs show, what a greedy cover chooses, and what each family adds."""
    write: Callable[[str], int] = sys.stdout.write
    caught = frozenset[str]().union(*shown.values())
    write(
        f"{len(caught)} of {len(known)} faults shown by {len(shown)} fixed runs, {sum(costs.values()):.2f} s\n"
    )
    write(f"missed by the fixed runs: {', '.join(sorted(set(known) - caught)) or 'none'}\n\n")
    chosen = greedy_cover(shown, costs)
    for run, count in chosen:
        write(f"{count:4} {costs[run]:7.3f} s  {run}\n")
    needed = {run for run, _ in chosen}
    unneeded = {run: costs[run] for run in shown if run not in needed}
    write(f"\n{len(chosen)} runs are a cover, {sum(costs[run] for run in needed):.2f} s; the others:\n")
    for run, cost in sorted(unneeded.items(), key=lambda each: -each[1]):
        write(f"     {cost:7.3f} s {len(shown[run]):4} faults  {run}\n")
    shares = {
        family: {
            fault: sum(fault in faults for faults in runs.values()) / len(runs)
            for fault in frozenset[str]().union(*runs.values())
        }
        for family, runs in drawn.items()
        if runs
    }
    left = set(known) - caught
    each = EXAMPLES["quick"] * SHARDS / max(len(shares), 1)
    write(f"\nfamily: faults shown, share that quick finds without it of {len(known)} faults\n")
    for family, share in shares.items():
        others = {name: each for name, each in shares.items() if name != family}
        total = (len(caught) + chance(left, others, each)) / len(known)
        alone = chance(known, others, each) / len(known)
        write(
            f"  {family:22} {len(share):4} {100.0 * total:6.1f} %, without fixed runs {100.0 * alone:6.1f} %\n"
        )


if __name__ == "__main__":
    main()
