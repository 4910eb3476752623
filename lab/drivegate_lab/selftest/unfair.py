"""The search turned on the checks: what no good controller meets in a fair scenario is a fault of a check or rule."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import CandidateFault, Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.containment.machine_memory import usual_workers
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.catalogue import applicable_checks, contract_of
from drivegate.drives.kinds import drive_for
from drivegate.gate.plan import EXAMPLES, SHARDS
from drivegate.gate.shard import DrawnRuns, run_drawn, searched_checks
from drivegate.gate.shrinking import ShrinkPlan, run_shrink
from drivegate.gate.warm_up import compile_missing, judges_on
from drivegate.gate.witnesses import Accusation, Acquittal, hear_witnesses
from drivegate.output.progress import Display
from drivegate.scenarios.simplification import size_of
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest.run import SHRINKING_RUNS, SelftestEffort
from drivegate_lab.selftest.subjects import correct_designs

_TITLE: Final = "correct controllers"
_MOST_HEARD: Final = 3
"""Failures of a check in one shard, the simplest ones, that witnesses are heard on."""


@dataclass(frozen=True)
class GoodShard:
    """A shard of the search with a good controller as its candidate."""

    candidate: Candidate
    runs: DrawnRuns
    budget: int
    """Runs that may be spent on making one scenario simpler."""


@dataclass(frozen=True)
class Failure:
    """A failure of a good controller in a fair scenario."""

    candidate: str
    check: str
    margin: Margin
    scenario: Mapping[str, Any]
    """The scenario as plain data, shrunk where no witness meets the check in it."""
    is_unfair: bool
    """Whether no witness meets the check there either."""

    def row(self, seed: int, drive: str) -> dict[str, Any]:
        return {
            "drive": drive,
            "seed": seed,
            "candidate": self.candidate,
            "check": self.check,
            "margin": self.margin.value,
            "measured": self.margin.measured,
            "unfair": self.is_unfair,
            "scenario": dict(self.scenario),
        }


@dataclass(frozen=True)
class ShardFailures:
    """What a shard showed of a good controller."""

    runs: int
    failures: tuple[Failure, ...]
    """At most one for each check, an unfair one if there is any."""
    fault: str | None = None
    """What the controller did beside its contract."""


def run_good(_host: JudgedCandidate, shard: GoodShard) -> ShardFailures:
    """Search with a good controller, and hear the witnesses where it fails a required check."""
    loaded = own_candidate(shard.candidate)
    try:
        runs = run_drawn(loaded, shard.runs).runs
    except CandidateFault as raised:
        return ShardFailures(0, (), f"{shard.candidate.name}: {raised.fault.message}")
    checks = sorted(searched_checks(applicable_checks(shard.runs.drive, loaded.candidate.declaration)))
    found = (_failure(loaded, check, _failed(check, runs), shard.budget) for check in checks)
    return ShardFailures(len(runs), tuple(failure for failure in found if failure is not None))


def _failed(check: str, runs: Iterable[JudgedRun]) -> Sequence[tuple[Mapping[str, Any], Margin]]:
    """Return the scenarios in which a check fails, the simplest first."""
    failed = [
        (run.scenario, margin)
        for run in runs
        for margin in run.margins
        if margin.check == check and not margin.met and not margin.advisory
    ]
    return sorted(failed, key=lambda failure: size_of(failure[0]))[:_MOST_HEARD]


def _failure(
    loaded: JudgedCandidate, check: str, failed: Sequence[tuple[Mapping[str, Any], Margin]], budget: int
) -> Failure | None:
    name = loaded.candidate.name
    for scenario, margin in failed:
        if _no_witness_meets(loaded, check, scenario, margin):
            shrunk = run_shrink(loaded, ShrinkPlan(scenario, check, budget))
            if shrunk is not None and _no_witness_meets(loaded, check, shrunk.scenario, shrunk.margin):
                return Failure(name, check, shrunk.margin, shrunk.scenario, is_unfair=True)
            return Failure(name, check, margin, scenario, is_unfair=True)
    return Failure(name, check, failed[0][1], failed[0][0], is_unfair=False) if failed else None


def _no_witness_meets(
    loaded: JudgedCandidate, check: str, scenario: Mapping[str, Any], margin: Margin
) -> bool:
    return isinstance(hear_witnesses(loaded, Accusation(check, ((scenario, margin),))), Acquittal)


def good_shards(effort: SelftestEffort) -> list[GoodShard]:
    """List the shards of every good controller of a drive's contract, and of every seed."""
    drive = drive_for(None, effort.drive)
    return [
        GoodShard(
            resolve_candidate(design.candidate),
            DrawnRuns(drive, seed * SHARDS + number, EXAMPLES[effort.name], search=effort.search),
            SHRINKING_RUNS[effort.name],
        )
        for seed in range(effort.seeds)
        for design in correct_designs(drive.contract, sensed=drive.position != "none")
        # Those near a limit and those that are judged by one check are no witnesses.
        if design.checks is None and not design.near
        for number in range(SHARDS)
    ]


def _searched(shards: Sequence[GoodShard], effort: SelftestEffort) -> Iterator[ShardFailures]:
    drive = drive_for(None, effort.drive)
    compile_missing([effort.drive])
    # The processes are started for the usual controller; the others are loaded next to it.
    host = resolve_candidate(contract_of(drive).usual_candidate)
    count = min(effort.workers or usual_workers(), len(shards))
    with WorkerPool(host, workers=count, preparation=judges_on(drive)) as pool:
        outcomes = pool.map([Job(run_good, shard) for shard in shards])
        for shard, outcome in zip(shards, outcomes, strict=True):
            if isinstance(outcome, Fault):
                yield ShardFailures(0, (), f"{shard.candidate.name}: {outcome.message}")
            else:
                yield outcome


def unfair_document(effort: SelftestEffort, display: Display) -> dict[str, Any]:
    """Search with all good controllers, and sum up what was found; it passes where nothing is unfair."""
    shards = good_shards(effort)
    display.begin(_TITLE, len(shards))
    drive = drive_for(None, effort.drive)
    runs, rows, faults = 0, [], []
    for number, (shard, outcome) in enumerate(zip(shards, _searched(shards, effort), strict=True), start=1):
        runs += outcome.runs
        found = [failure.row(shard.runs.seed // SHARDS, drive.name) for failure in outcome.failures]
        rows += found
        # At once, since a search of many hours may be ended before it sums up.
        for row in (row for row in found if row["unfair"]):
            where = f"{row['candidate']} on {row['drive']}, seed {row['seed']}"
            display.announce(f"{row['check']} is met by no controller: {where}, {row['measured']}")
        faults += [] if outcome.fault is None else [outcome.fault]
        display.advance(number, len(shards), f"{shard.candidate.name} on {drive.name}: {runs} runs")
    return {
        "kind": "selftest-unfair",
        "drive": drive.identity(),
        "effort": effort.name,
        "seeds": effort.seeds,
        "runs": runs,
        "unfair": [row for row in rows if row["unfair"]],
        "met_by_a_witness": [row for row in rows if not row["unfair"]],
        "faults": faults,
        "passed": not faults and not any(row["unfair"] for row in rows),
    }


@dataclass(frozen=True)
class DrawnDrives:
    """Drives that are drawn at random."""

    kind: str
    """One of `drivegate_lab.drawn.kinds.DRAWN_KINDS`."""
    count: int
    seed: int


def unfair_on_drives(drives: DrawnDrives, effort: SelftestEffort, display: Display) -> dict[str, Any]:
    """Search with all good controllers on each of some drawn drives, and sum up what was found."""
    kind = DRAWN_KINDS[drives.kind]
    drawn = [kind.draw(drives.seed, number).document for number in range(1, drives.count + 1)]
    parts = [unfair_document(replace(effort, drive=document), display) for document in drawn]
    listed = {
        name: [each for part in parts for each in part[name]]
        for name in ("unfair", "met_by_a_witness", "faults")
    }
    return {
        "kind": "selftest-unfair",
        "drives": [part["drive"] for part in parts],
        "effort": effort.name,
        "seeds": effort.seeds,
        "runs": sum(part["runs"] for part in parts),
        **listed,
        "passed": all(part["passed"] for part in parts),
    }


def keep_unfair(document: Mapping[str, Any], folder: Path) -> list[str]:
    """Write the unfair scenarios as files that `drivegate simulate --case` takes; return their names."""
    names = []
    for number, row in enumerate(document["unfair"], start=1):
        names.append(f"unfair-{number:03d}-{row['check']}.json")
        write_atomically(folder / names[-1], json.dumps(row["scenario"], indent=2) + "\n")
    return names
