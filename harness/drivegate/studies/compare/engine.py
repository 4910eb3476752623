"""The runs of the candidates of a comparison on one drive, one after another, in contained processes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind, bounded_line
from drivegate.candidates.kinds import untimed_because
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun
from drivegate.containment.machine_memory import usual_workers
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import PlannedRun, Row
from drivegate.drives.running import recorded
from drivegate.gate.events import CheckStarted, Compiling, Event, RunDone
from drivegate.gate.plan import Origin, Work, planned_work
from drivegate.gate.warm_up import compile_kernels, judges_on, uncompiled_kinds
from drivegate.results.document import CheckSection
from drivegate.results.verdict import check_outcomes
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import HarnessFault

CHECKS_EFFORT: Final = "quick"
"""Effort of the checks whose margins are compared."""
MOST_FAULTS: Final = 3
"""Faults after which a candidate is not run any further; one hang is enough."""
COMPARED, FAULTED, REFUSED = "compared", "faulted", "refused"
"""What can become of a candidate."""

Best: TypeAlias = Mapping[tuple[str, float], Any]
"""The best possible, by what was found and where."""


@dataclass
class Compared:
    """What has become of one candidate."""

    specification: str
    """The string that named it."""
    label: str
    """Its name, which no other candidate of the comparison has."""
    candidate: Candidate | None = None
    """The candidate, if there is one."""
    error: Exception | None = None
    """Why it was refused, or what failed in drivegate."""
    figures: dict[int, Row] = field(default_factory=dict)
    """What was measured, by the index of the planned run."""
    faults: list[Fault] = field(default_factory=list)
    """The candidate's faults."""
    complete: bool = True
    """Whether every planned run was made."""
    outcomes: tuple[CheckSection, ...] | None = None
    """Outcomes of the checks; None where they were not made."""
    timing: Row = field(default_factory=dict)
    """Numbers that depend on the machine."""

    @property
    def status(self) -> str:
        """What has become of it."""
        if self.error is not None or self.candidate is None:
            return REFUSED
        return FAULTED if self.faults else COMPARED

    @property
    def failed_checks(self) -> list[str] | None:
        """The required checks that it fails; None where they were not made."""
        if self.outcomes is None:
            return None
        return [made.id for made in self.outcomes if made.level == "required" and made.verdict == "fail"]

    def goes_on_after(self, fault: Fault) -> bool:
        """Store a fault, and return True if the candidate is run any further."""
        self.faults.append(fault)
        ends = fault.kind is FaultKind.HANG or fault.phase == "loading" or len(self.faults) >= MOST_FAULTS
        self.complete &= not ends
        return not ends


def prepared(drive: DriveDocument) -> Iterator[Event]:
    """Compile the kernels of a drive's kind if they are still to be compiled."""
    kinds = uncompiled_kinds([drive])
    if kinds:
        yield Compiling(kinds)
        compile_kernels(kinds)


def find_best(plan: Sequence[PlannedRun], workers: int | None, found: dict[Any, Any]) -> Iterator[Event]:
    """Find what the drive can do at best in the runs of a plan, as far as the contract knows."""
    contract = contract_of(plan[0].scenario.drive)
    jobs = contract.comparison().best(plan)
    if not jobs:
        return
    yield CheckStarted("the best possible", len(jobs))
    solver, preparation = resolve_candidate(contract.usual_candidate), judges_on(plan[0].scenario.drive)
    with WorkerPool(solver, workers=_count(workers), preparation=preparation) as pool:
        for done, (what, outcome) in enumerate(zip(jobs, pool.map(list(jobs.values())), strict=True), 1):
            if isinstance(outcome, Fault):
                raise HarnessFault(f"an operating point cannot be solved: {outcome.message}")
            found[what] = outcome
            yield RunDone(done, len(jobs), "operating points", "")


def measured(loaded: JudgedCandidate, planned: PlannedRun) -> Row:
    """Run a candidate through a planned run; this is what a worker process does."""
    comparison = contract_of(planned.scenario.drive).comparison()
    every = comparison.trace_every(planned)
    record = recorded(loaded, planned.scenario, loaded.controller(), trace_every=every)
    return comparison.measure(planned, record)


def timed(loaded: JudgedCandidate, scenario: Scenario) -> Row:
    """Time a candidate's steps on what it sensed in a run; this is what a worker process does."""
    controller = loaded.controller()
    record = recorded(loaded, scenario, controller, trace_every=1)
    step = contract_of(scenario.drive).step_seconds(controller, record)
    size = getattr(controller, "state_size", None)
    return {
        "step_us": 1e6 * step,
        "share_of_period_percent": 100.0 * step / scenario.control_period_s,
        "state_bytes": int(size) if isinstance(size, int) and size > 0 else None,
    }


def run_plan(
    compared: Compared, plan: Sequence[PlannedRun], *, seed: int, workers: int | None, checks: bool
) -> Iterator[Event]:
    """Run a candidate through a plan, let the checks judge it, and time its steps."""
    candidate = compared.candidate
    assert candidate is not None, "only a candidate can be run"
    drive = plan[0].scenario.drive
    work = _checks_work(candidate, drive, seed) if checks else []
    total = len(plan) + 1 + sum(item.runs for item in work)
    yield CheckStarted(compared.label, total)
    done = 0
    with WorkerPool(candidate, workers=_count(workers), preparation=judges_on(drive)) as pool:
        for index, outcome in enumerate(pool.map([Job(measured, planned) for planned in plan])):
            done += 1
            yield RunDone(done, total, plan[index].label, "")
            if not isinstance(outcome, Fault):
                compared.figures[index] = outcome
            elif not compared.goes_on_after(outcome):
                break
        if compared.complete and work:
            yield from _run_checks(compared, pool, drive, work, done, total)
        if compared.complete:
            for timing in pool.map([Job(timed, plan[0].scenario)]):
                if not isinstance(timing, Fault):
                    compared.timing = timing


def _count(workers: int | None) -> int:
    return workers or usual_workers()


def _checks_work(candidate: Candidate, drive: DriveDocument, seed: int) -> list[Work]:
    """Plan the checks, but for the one of times, which are measured separately."""
    work = planned_work(CHECKS_EFFORT, seed, drive=drive, declaration=candidate.declaration)
    return [item for item in work if item.origin is not Origin.TIMED]


def _run_checks(
    compared: Compared, pool: WorkerPool, drive: DriveDocument, work: Sequence[Work], done: int, total: int
) -> Iterator[Event]:
    runs: list[JudgedRun] = []
    outcomes = pool.map([item.job for item in work])
    for item, outcome in zip(work, outcomes, strict=True):
        done += item.runs
        yield RunDone(done, total, item.label, "")
        if not isinstance(outcome, Fault):
            runs.extend(outcome.runs)
        elif not compared.goes_on_after(outcome):
            break
    assert compared.candidate is not None, "only a candidate has checks"
    compared.outcomes = check_outcomes(
        runs,
        compared.candidate.declaration,
        drive,
        complete=compared.complete and not compared.faults,
        untimed_because=untimed_because(compared.candidate),
    )


def named_candidates(
    specifications: Sequence[str], resolved: Sequence[Candidate | Exception]
) -> list[Compared]:
    """Begin with every candidate that was named, refused ones among them."""
    names = [
        found.name if isinstance(found, Candidate) else bounded_line(specification)[:200]
        for specification, found in zip(specifications, resolved, strict=True)
    ]
    all_compared = labelled(specifications, names)
    for compared, found in zip(all_compared, resolved, strict=True):
        if isinstance(found, Exception):
            compared.error = found
        else:
            compared.candidate = found
    return all_compared


def labelled(specifications: Iterable[str], names: Iterable[str]) -> list[Compared]:
    """Label every candidate, each differently."""
    made: list[Compared] = []
    for specification, name in zip(specifications, names, strict=True):
        label, number = name, 1
        while label in {other.label for other in made}:
            number += 1
            label = f"{name} ({number})"
        made.append(Compared(specification, label))
    return made
