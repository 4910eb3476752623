"""The self-test's work: every faulty controller before its check, every correct design before all of them."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import FAULTY_PREFIX
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import ShardOutcome
from drivegate.containment.machine_memory import usual_workers
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import drive_for
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import Event
from drivegate.gate.options import CheckOptions
from drivegate.gate.plan import Origin, Work, planned_work
from drivegate.gate.warm_up import compile_missing, judges_on
from drivegate.output.event_loop import finished
from drivegate.output.progress import progress_on
from drivegate.results.document import CheckSection, ResultDocument
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.faults.seeded_fault import FaultOnDrive, SeededFault
from drivegate_lab.selftest.matrix import DesignRow, FaultRow, LeastMargin
from drivegate_lab.selftest.subjects import CorrectDesign
from drivegate_lab.selftest.trial import Trial, TrialOutcome, run_trial
from drivegate_models.errors import HarnessFault

if TYPE_CHECKING:
    from drivegate_lab.selftest.matrix import Matrix

_TITLE = "faulty controllers"
SHRINKING_RUNS: Final = {"quick": 5, "default": 15, "nightly": 60}
"""Runs that may be spent on making one counterexample simpler, by effort."""

_JUDGED_BY: Final = {"FLO-1": (Origin.SCRIPTS,), "TIM-1": (Origin.TIMED,)}
# Of a command at an end of its range, which is right, the margin is exactly 0.
_MET_AT_THE_END: Final = frozenset({"ADV-2", "CMD-1"})
_SEEDED: Final = (Origin.SCRIPTS, Origin.DRAWN)


@dataclass(frozen=True)
class SelftestEffort:
    """How much is searched, and with what."""

    name: str = "default"
    """``quick``, ``default`` or ``nightly``."""
    seeds: int = 1
    """Number of seeds, from 0 on."""
    workers: int | None = None
    """Number of processes; None for as many as there are processors."""
    search: bool = True
    """Whether to climb toward small margins."""
    drawn_only: bool = False
    """Whether to leave the fixed scenarios out, so that the drawn ones have to catch the faults."""
    drive: DriveDocument | None = None
    """The drive; None for the default."""


def try_faults(faults: Sequence[SeededFault], effort: SelftestEffort) -> Iterator[FaultRow]:
    """Put faulty controllers before the checks named for them."""
    drive = drive_for(None, effort.drive)
    compile_missing([effort.drive])
    resolved = [fault.on(drive) for fault in faults]
    jobs = [
        Job(run_trial, planned_trial(fault, effort))
        for fault, on_drive in zip(faults, resolved, strict=True)
        if on_drive.idle_because is None
    ]
    if not jobs:
        yield from (
            _row(fault, on_drive, None, effort) for fault, on_drive in zip(faults, resolved, strict=True)
        )
        return
    # The processes are started for the controller that has no fault; the faulty ones are loaded beside it.
    host = resolve_candidate(contract_of(drive).usual_candidate)
    count = effort.workers or usual_workers()
    with WorkerPool(host, workers=min(count, len(jobs)), preparation=judges_on(drive)) as pool:
        outcomes = pool.map(jobs)
        for fault, on_drive in zip(faults, resolved, strict=True):
            yield _row(fault, on_drive, next(outcomes) if on_drive.idle_because is None else None, effort)


def planned_trial(fault: SeededFault, effort: SelftestEffort) -> Trial:
    """Plan what a faulty controller is put through."""
    candidate = resolve_candidate(FAULTY_PREFIX + fault.name)
    check = fault.check_on(drive_for(None, effort.drive))
    origins = _JUDGED_BY.get(check, (Origin.DRAWN,) if effort.drawn_only else (Origin.FIXED, Origin.DRAWN))
    plans = {
        seed: planned_work(
            effort.name,
            seed,
            drive=effort.drive,
            declaration=candidate.declaration,
            search=effort.search,
        )
        for seed in range(effort.seeds)
    }
    return Trial(
        candidate=candidate,
        base=resolve_candidate(fault.base),
        check=check,
        fixed=_jobs(plans[0], origins, seeded=False),
        seeded={seed: _jobs(plan, origins, seeded=True) for seed, plan in plans.items()},
        budget=SHRINKING_RUNS[effort.name],
    )


def _jobs(plan: Sequence[Work], origins: Sequence[Origin], *, seeded: bool) -> tuple[Job[ShardOutcome], ...]:
    return tuple(item.job for item in plan if item.origin in origins and (item.origin in _SEEDED) is seeded)


def _row(
    fault: SeededFault, on_drive: FaultOnDrive, outcome: TrialOutcome | Fault | None, effort: SelftestEffort
) -> FaultRow:
    """Return what has become of a fault; without an outcome, why it was not tried."""
    if outcome is None:
        outcome = TrialOutcome({}, (), 0, (), 0)
    if isinstance(outcome, Fault):
        faults = (f"{outcome.kind.value}: {outcome.message}",)
        outcome = TrialOutcome(dict.fromkeys(range(effort.seeds)), (), 0, faults, 0)
    return FaultRow(
        name=fault.name,
        kind=fault.kind,
        sentence=on_drive.sentence,
        check=on_drive.check,
        catches=outcome.catches,
        failing=outcome.failing,
        runs=outcome.runs,
        faults=outcome.faults,
        unconvincing=outcome.unconvincing,
        shown_by=on_drive.shown_by,
        idle_because=on_drive.idle_because,
    )


def design_check(design: CorrectDesign, seed: int, effort: SelftestEffort) -> Iterator[Event]:
    """Check a correct design as any candidate is checked."""
    name = effort.name if design.checks is None else "quick"
    options = CheckOptions(
        drive=effort.drive, effort=name, seed=seed, workers=effort.workers, search=effort.search
    )
    return check_candidate(resolve_candidate(design.candidate), options)


def judged_design(design: CorrectDesign, result: ResultDocument) -> DesignRow:
    """Return whether a whole check accuses a correct design."""
    for outcome in result.checks:
        if outcome.subject == "plant" and outcome.verdict == "fail":
            raise HarnessFault(
                f"the plant failed while '{result.candidate.name}' was checked with seed {result.seed}: "
                f"{outcome.id}, {outcome.message}"
            )
    judged = [outcome for outcome in result.checks if design.checks is None or outcome.id in design.checks]
    # Of a correct controller, a failure that no witness avoids is a fault of the checks all the same.
    failed = [outcome for outcome in judged if outcome.verdict in ("fail", "contested")]
    accused_by = {outcome.id: outcome.message for outcome in failed if outcome.level == "required"}
    advised_by = tuple(outcome.id for outcome in failed if outcome.level != "required")
    if design.checks is None:
        verdict, acquitted = result.verdict, result.exit_code == 0 and result.verdict != "contested"
    else:
        acquitted = not result.faults and all(outcome.verdict == "pass" for outcome in judged)
        verdict = "pass" if acquitted else "fail"
    return DesignRow(
        name=result.candidate.name,
        seed=result.seed,
        verdict=verdict,
        accused_by=accused_by,
        acquitted=acquitted,
        advised_by=advised_by,
        near=design.near,
        least=least_margin(judged),
    )


def least_margin(outcomes: Sequence[CheckSection]) -> LeastMargin | None:
    """Find the least margin of the required checks, without those whose margin depends on the machine."""
    judged = [
        LeastMargin(outcome.id, outcome.margin, outcome.measured or "")
        for outcome in outcomes
        if outcome.level == "required" and outcome.margin is not None and outcome.id not in _MET_AT_THE_END
    ]
    return min(judged, key=lambda least: least.margin, default=None)


def chosen_names(names: Sequence[str], kind: str) -> tuple[str, ...]:
    """Find faulty controllers for drives of a kind by their names; without any, all."""
    from drivegate.drives.kinds import DRIVE_KINDS
    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_lab.selftest.subjects import chosen_faults

    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    return tuple(fault.name for fault in chosen_faults(names, drive))


def selftested(names: Sequence[str], effort: SelftestEffort, *, designs: bool) -> Matrix:
    """Put faulty controllers before the checks, all of them without names, and correct designs if requested."""
    from drivegate.contracts.catalogue import contract_of
    from drivegate.drives.kinds import drive_for
    from drivegate_lab.selftest.matrix import Matrix
    from drivegate_lab.selftest.subjects import chosen_faults

    drive = drive_for(None, effort.drive)
    rows = _tried(chosen_faults(names, drive), effort)
    judged = _judged(drive, effort) if designs else ()
    return Matrix(tuple(check.id for check in contract_of(drive).checks), rows, judged)


def _tried(faults: Sequence[SeededFault], effort: SelftestEffort) -> tuple[FaultRow, ...]:
    # It brings the compiled plant, which a name that is refused does not need.

    rows: list[FaultRow] = []
    with progress_on(sys.stderr) as display:
        display.begin(_TITLE, len(faults))
        for row in try_faults(faults, effort):
            rows.append(row)
            # Each line is of another controller, so none is left out.
            display.advance(len(rows), len(faults), _in_short(row), always=True)
    return tuple(rows)


def _judged(drive: DriveDocument, effort: SelftestEffort) -> tuple[DesignRow, ...]:
    from drivegate_lab.selftest.subjects import correct_designs

    rows = []
    for design in correct_designs(drive.contract, sensed=drive.position != "none"):
        for seed in range(effort.seeds):
            with progress_on(sys.stderr) as display:
                result = finished(design_check(design, seed, effort), display)
            rows.append(judged_design(design, result))
    return tuple(rows)


def _in_short(row: FaultRow) -> str:
    """State in a few words what has become of a faulty controller."""
    slowest = row.slowest
    if not row.applies:
        return f"{row.name}: does not apply"
    if slowest is None:
        return f"{row.name}: missed by {row.check} in {row.runs} runs"
    return f"{row.name}: caught by {row.check} in run {slowest.runs}"
