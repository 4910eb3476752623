"""Running several candidates through the same plan, one after another, in contained processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, TypeAlias

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind, bounded_line
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.judging import JudgedRun
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.gate.events import CheckStarted, Compiling, Event, RunDone
from drivegate.gate.plan import Origin, Work, planned_work
from drivegate.gate.warm_up import compile_kernels, uncompiled_kinds
from drivegate.results.result import CheckOutcome
from drivegate.results.verdict import check_outcomes
from drivegate.studies.compare.oracle import greatest_torque, oracle_point, solved
from drivegate.studies.compare.plan import PlannedRun
from drivegate.studies.compare.run import Figures, measured, timed
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import HarnessFault

CHECKS_EFFORT: Final = "quick"
"""Effort of the checks whose margins are compared."""
MOST_FAULTS: Final = 3
"""Faults after which a candidate is not run any further; one hang is enough."""
_SOLVER: Final = "initial"


class Planned(Protocol):
    """A run that every candidate makes, whatever is measured in it."""

    @property
    def label(self) -> str:
        """What it is, for people."""

    @property
    def scenario(self) -> Scenario:
        """What is run."""


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
    figures: dict[int, Figures] = field(default_factory=dict)
    """What was measured, by the index of the planned run."""
    faults: list[Fault] = field(default_factory=list)
    """The candidate's faults."""
    complete: bool = True
    """Whether every planned run was made."""
    outcomes: tuple[CheckOutcome, ...] | None = None
    """What the checks came to; None where they were not made."""
    timing: dict[str, Any] = field(default_factory=dict)
    """Numbers that depend on the machine."""

    def goes_on_after(self, fault: Fault) -> bool:
        """Keep a fault, and tell whether the candidate is run any further."""
        self.faults.append(fault)
        ends = fault.kind is FaultKind.HANG or fault.phase == "loading" or len(self.faults) >= MOST_FAULTS
        self.complete &= not ends
        return not ends


Refused: TypeAlias = tuple[tuple[str, Exception], ...]
"""Specification and error of each candidate that could not be compared."""


def refused_of(all_compared: Iterable[Compared]) -> Refused:
    """List who could not be compared."""
    return tuple(
        (compared.specification, compared.error) for compared in all_compared if compared.error is not None
    )


def prepared(drive: DriveDocument) -> Iterator[Event]:
    """Compile the kernels of a drive's kind if they are still to be compiled."""
    kinds = uncompiled_kinds([drive])
    if kinds:
        yield Compiling()
        compile_kernels(kinds)


def solve_plan(plan: Sequence[PlannedRun], workers: int | None, found: dict[str, Any]) -> Iterator[Event]:
    """Find what the drive can do at best at every operating point of a plan."""
    points = [oracle_point(planned) for planned in plan if planned.group == "points"]
    by_speed = {point.speed_rpm: point for point in points}
    jobs: list[Job[Any]] = [Job(solved, point) for point in points]
    jobs += [Job(greatest_torque, point) for point in by_speed.values()]
    yield CheckStarted("the best possible", len(jobs))
    outcomes: list[Any] = []
    with WorkerPool(resolve_candidate(_SOLVER), workers=_count(workers)) as pool:
        for outcome in pool.map(jobs):
            if isinstance(outcome, Fault):
                raise HarnessFault(f"an operating point cannot be solved: {outcome.message}")
            outcomes.append(outcome)
            yield RunDone(len(outcomes), len(jobs), "operating points", "")
    found["points"] = outcomes[: len(points)]
    found["envelope"] = [
        {"speed_rpm": speed, "torque_nm": torque}
        for speed, torque in zip(by_speed, outcomes[len(points) :], strict=True)
    ]


def run_plan(
    compared: Compared,
    plan: Sequence[Planned],
    *,
    seed: int,
    workers: int | None,
    checks: bool,
    measure: Callable[[JudgedCandidate, Any], Figures] = measured,
    time_step: Callable[[JudgedCandidate, Any], dict[str, Any]] | None = timed,
) -> Iterator[Event]:
    """Run a candidate through a plan, and let the checks judge it."""
    candidate = compared.candidate
    assert candidate is not None, "only a candidate can be run"
    drive = plan[0].scenario.drive
    work = _checks_work(candidate, drive, seed) if checks else []
    total = len(plan) + (time_step is not None) + sum(item.runs for item in work)
    yield CheckStarted(compared.label, total)
    done = 0
    with WorkerPool(candidate, workers=_count(workers)) as pool:
        for index, outcome in enumerate(pool.map([Job(measure, planned) for planned in plan])):
            done += 1
            yield RunDone(done, total, plan[index].label, "")
            if not isinstance(outcome, Fault):
                compared.figures[index] = outcome
            elif not compared.goes_on_after(outcome):
                break
        if compared.complete and work:
            yield from _run_checks(compared, pool, drive, work, done, total)
        if compared.complete and time_step is not None:
            for timing in pool.map([Job(time_step, plan[0].scenario)]):
                if not isinstance(timing, Fault):
                    compared.timing = timing


def _count(workers: int | None) -> int:
    return workers or os.cpu_count() or 1


def _checks_work(candidate: Candidate, drive: DriveDocument, seed: int) -> list[Work]:
    """Plan the checks, but for the one that takes times: those are taken apart."""
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
        runs, compared.candidate.declaration, drive, complete=compared.complete and not compared.faults
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
    """Give every candidate a label of its own."""
    made: list[Compared] = []
    for specification, name in zip(specifications, names, strict=True):
        label, number = name, 1
        while label in {other.label for other in made}:
            number += 1
            label = f"{name} ({number})"
        made.append(Compared(specification, label))
    return made
