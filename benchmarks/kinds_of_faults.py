"""Measure at which effort each kind of fault is caught: ``python benchmarks/kinds_of_faults.py DRIVE --write``.

For each kind of operation that is rarely tried, with its faulty controllers, the table has the fixed run that catches
each. A fixed run is the same at every effort and with every seed. What no fixed run catches is searched for with every
seed, first at effort quick, then at default. With ``--alone 8`` a further column has with how many of eight seeds the
drawn runs of a quick check catch it without the fixed runs. A trial ends with its first failure.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import Job
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import drive_for
from drivegate.gate.plan import EXAMPLES, shard_seeds
from drivegate.gate.shard import DrawnRuns, FixedRuns, run_drawn
from drivegate.gate.warm_up import compile_missing
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.selftest.operations import operations
from drivegate_lab.selftest.run import SelftestEffort, planned_trial
from drivegate_lab.selftest.subjects import chosen_faults
from drivegate_lab.selftest.trial import Trial, TrialOutcome, run_trial
from measured_text import write_measured

PAGE: Final = Path(__file__).parents[1] / "docs" / "self_test.md"
OTHERS: Final = "others"
EFFORTS: Final = ("quick", "default")
HEADS: Final = ("kind of operation", "faulty controller", "check", "caught in", "caught at")


@dataclass(frozen=True)
class Row:
    """What has become of one faulty controller."""

    kind: str
    fault: str
    check: str
    run: str
    """The fixed run that catches it; empty for none."""
    caught: str
    """At which efforts, and with how many seeds."""
    alone: str = ""
    """With how many seeds drawn runs alone catch it; empty where that was not measured."""

    def cells(self) -> tuple[str, ...]:
        run = f"`{self.run}`" if self.run else "drawn runs"
        return (
            self.kind,
            f"`{self.fault}`",
            self.check,
            run,
            self.caught,
            *([self.alone] if self.alone else []),
        )


def expected_first(trial: Trial, expected: Collection[str]) -> Trial:
    """Return a trial whose fixed runs begin with those of the fault's kind, and which shrinks nothing."""

    def is_other(job: object) -> bool:
        plan = getattr(job, "payload", None)
        return not (isinstance(plan, FixedRuns) and any(run.name in expected for run in plan.scenarios))

    return replace(trial, fixed=tuple(sorted(trial.fixed, key=is_other)), budget=0)


def without_fixed_runs(trial: Trial, effort: SelftestEffort) -> Trial:
    """Return a trial that has the drawn runs of each seed alone."""
    drive = drive_for(None, effort.drive)
    seeded = {
        seed: tuple(
            Job(run_drawn, DrawnRuns(drive, shard, EXAMPLES[effort.name])) for shard in shard_seeds(seed)
        )
        for seed in range(effort.seeds)
    }
    return replace(trial, fixed=(), seeded=seeded, budget=0)


def tried(trial: Trial) -> TrialOutcome:
    """Run a trial in this process."""
    return run_trial(own_candidate(trial.candidate), trial)


def caught_with(outcome: TrialOutcome) -> str:
    """Write with how many seeds a fault was caught."""
    caught = sum(catch is not None for catch in outcome.catches.values())
    return f"{caught} of {len(outcome.catches)}"


def measured(
    kind: str, fault: SeededFault, expected: Collection[str], effort: SelftestEffort, alone: int
) -> Row:
    """Try a fault in fixed runs, and in drawn ones where no fixed run catches it."""
    trial = planned_trial(fault, replace(effort, seeds=1))
    catch = tried(replace(expected_first(trial, expected), seeded={0: ()})).catches[0]
    texts = []
    for name in () if catch is not None else EFFORTS:
        outcome = tried(without_fixed_runs(trial, replace(effort, name=name)))
        texts.append(f"{name} {caught_with(outcome)}")
        if None not in outcome.catches.values():
            break
    by_drawing = caught_with(tried(without_fixed_runs(trial, replace(effort, seeds=alone)))) if alone else ""
    return Row(
        kind,
        fault.name,
        fault.check,
        "" if catch is None else catch.scenario,
        "every effort and seed" if catch is not None else ", ".join(texts),
        by_drawing,
    )


def subjects(drive: DriveDocument, *, every: bool) -> Iterator[tuple[str, SeededFault, frozenset[str]]]:
    """List the kinds of operation with each faulty controller that does something on the drive, and the kind's runs."""
    known = set()
    for each in operations(drive):
        for fault in each.faults:
            known.add(fault.name)
            if fault.on(drive).idle_because is None:
                yield each.kind, fault, frozenset(run.name for run in each.runs)
    for fault in chosen_faults((), drive) if every else ():
        if fault.name not in known and fault.on(drive).idle_because is None:
            yield OTHERS, fault, frozenset()


def table(rows: Sequence[Row]) -> str:
    """Write the table in Markdown."""
    heads = (*HEADS, *(["drawing alone, quick"] if any(row.alone for row in rows) else []))
    lines: list[Sequence[str]] = [heads, ["---"] * len(heads), *(row.cells() for row in rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def summary(drive: str, rows: Sequence[Row], seeds: int, seconds: float) -> str:
    """Write what the table has, in words."""
    return (
        f"Measured on `{drive}` with {seeds} seeds, in {seconds:.0f} s of processor time: "
        f"{sum(bool(row.run) for row in rows)} of {len(rows)} faults are caught in a fixed run."
    )


def place_of(drive: str) -> str:
    """Return the name of a drive's place in the page."""
    return f"kinds of faults on {drive.replace('-', ' ')}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drive")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--alone", type=int, default=0, help="seeds without fixed runs")
    parser.add_argument("--all", action="store_true", help="every faulty controller of the contract")
    parser.add_argument("--fault", action="append", default=[], help="this one alone; may be given again")
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE.name}")
    given = parser.parse_args()
    drive = load_drive(given.drive)
    compile_missing([drive])
    own_candidate(resolve_candidate(contract_of(drive).usual_candidate)).controller()
    effort = SelftestEffort("quick", seeds=given.seeds, drive=drive)
    begun, rows = time.process_time(), []
    for kind, fault, runs in subjects(drive, every=given.all):
        if not given.fault or fault.name in given.fault:
            rows.append(measured(kind, fault, runs, effort, given.alone))
            sys.stderr.write(f"{time.process_time() - begun:7.1f} s {' | '.join(rows[-1].cells())}\n")
    text = f"{summary(drive.name, rows, given.seeds, time.process_time() - begun)}\n\n{table(rows)}"
    sys.stdout.write(f"{text}\n")
    if given.write:
        write_measured(PAGE, place_of(drive.name), text)


if __name__ == "__main__":
    main()
