"""The check of a candidate: plan, work in contained processes, verdict. It reports what it does as events."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass, field, replace
from datetime import UTC, datetime
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.checks.check import InfeasibleScenario, JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin, margin_in_words
from drivegate.containment.candidate_isolation import isolating_layers
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkEnded, WorkerPool
from drivegate.containment.watches import SlowRun
from drivegate.contracts.catalogue import CONTRACTS, all_checks, contract_of
from drivegate.drives.abilities import refuse_unreachable
from drivegate.drives.kinds import drive_for
from drivegate.gate.events import (
    CheckFinished,
    CheckPlan,
    CheckStarted,
    Compiling,
    DriveFrom,
    Event,
    Recording,
    RunDone,
    Running,
    Shrinking,
    WitnessesHeard,
)
from drivegate.gate.focus import WHOLE, Focus
from drivegate.gate.plan import EXAMPLES, REPEATED, Origin, Work, planned_work
from drivegate.gate.recording import behaviour_job, recording_job, recording_plans, with_recordings
from drivegate.gate.repetition import repeated_elsewhere
from drivegate.gate.same_drive import require_same_drive
from drivegate.gate.shrinking import Shrunk, simplest_failures, with_simplest
from drivegate.gate.warm_up import compile_kernels, judges_on, uncompiled_kinds
from drivegate.gate.witnesses import Acquittal, Defence, accusations, with_witnesses
from drivegate.results.baseline import Baseline, compared
from drivegate.results.counterexample import Counterexample
from drivegate.results.provenance import machine, provenance
from drivegate.results.result import (
    BaselineComparison,
    CheckOutcome,
    CheckResult,
    FixedMargins,
    counted_levels,
)
from drivegate.results.verdict import candidate_verdict, check_outcomes, costly_steps, machine_dependent
from drivegate.results.waivers import Waiver, present_day, under_waivers
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError

_TELLING: Final = frozenset(
    check.id
    for checks in (bundle.checks() for bundle in CONTRACTS.values())
    for check in checks
    if check.level == "required" and check.subject == "candidate" and not check.volatile
)
"""Checks whose margins progress shows; one of 0 that is met is a clamped command's."""
_GRACE_SECONDS: Final = 2.0
"""How long work that has begun may go on after the time has run out."""
_VOLATILE: Final = frozenset(check.id for check in all_checks().values() if check.volatile)


@dataclass
class _Progress:
    """What the runs have come to so far."""

    deadline: float | None
    focus: Focus
    counting: frozenset[str]
    runs: dict[Origin, list[JudgedRun]] = field(default_factory=lambda: {origin: [] for origin in Origin})
    faults: list[Fault] = field(default_factory=list)
    infeasible: list[InfeasibleScenario] = field(default_factory=list)
    complete: bool = True
    stopped: bool = False
    incomplete: str | None = None

    def is_overdue(self) -> bool:
        """Return True if work that has begun must end."""
        return self.deadline is not None and time.monotonic() > self.deadline + _GRACE_SECONDS

    def end(self) -> None:
        """Note that work was ended; if it was not for the time, for a request."""
        if not self.cuts_short():
            self.incomplete = "interrupted"

    def add(self, work: Work, outcome: ShardOutcome | Fault) -> None:
        if isinstance(outcome, Fault):
            self.add_fault(outcome)
        else:
            self.runs[work.origin].extend(outcome.runs)
            self.infeasible.extend(outcome.infeasible)

    def add_fault(self, fault: Fault) -> None:
        if (fault.kind, fault.message) not in [(known.kind, known.message) for known in self.faults]:
            self.faults.append(fault)

    @property
    def all_runs(self) -> list[JudgedRun]:
        return [run for origin in Origin for run in self.runs[origin]]

    @property
    def stops_here(self) -> bool:
        if not self.focus.stop_at_first:
            return False
        return bool(self.faults) or self.focus.broken_by(self.all_runs, self.counting)

    def cuts_short(self) -> bool:
        """Return True if no more work may begin; called where there is some, so that the check is incomplete then."""
        if self.incomplete is None and self.deadline is not None and time.monotonic() > self.deadline:
            self.incomplete = "max time"
        return self.incomplete is not None


def _counting(
    candidate: Candidate, drive: DriveDocument, fail_on: str, waivers: Sequence[Waiver]
) -> frozenset[str]:
    """Return the identifiers of the checks that can fail the candidate."""
    levels = counted_levels(fail_on)
    waived = {waiver.check for waiver in waivers if waiver.candidate == candidate.name}
    return frozenset(check.id for check in contract_of(drive).checks() if check.level in levels) - waived


def check_candidate(
    candidate: Candidate,
    *,
    drive: DriveDocument | None = None,
    drive_named: str | None = None,
    effort: str = "default",
    seed: int = 0,
    workers: int | None = None,
    max_time: float | None = None,
    search: bool = True,
    corpus: Sequence[Counterexample] = (),
    baseline: Baseline | None = None,
    waivers: Sequence[Waiver] = (),
    fail_on: str = "required",
    contested: str = "pass",
    focus: Focus = WHOLE,
    on_slow: Callable[[SlowRun], None] | None = None,
    is_ended: Callable[[], bool] = lambda: False,
) -> Iterator[Event]:
    """Check a candidate on a drive, and report progress as events; `on_slow` is called with a run that will take long.

    Once `is_ended` returns True, the check ends with what its runs have shown by then.
    `drive_named` is the string that named the drive, which the result repeats.
    """
    if effort not in EXAMPLES:
        raise InputError(f"the effort is '{effort}', but must be one of {', '.join(EXAMPLES)}")
    if seed < 0:
        raise InputError(f"the seed is {seed}, but must be 0 or more")
    judged_on = drive_for(candidate, drive)
    require_same_drive(
        judged_on,
        baseline=baseline,
        counterexamples=(*focus.first, *corpus),
        waivers=[waiver for waiver in waivers if waiver.candidate == candidate.name],
    )
    focus = focus.within(judged_on.contract, [check.id for check in contract_of(judged_on).checks()])
    # What a candidate does not declare is known before anything is compiled or run.
    focus.require_judged(check_outcomes((), candidate.declaration, judged_on, complete=False))
    uncompiled = uncompiled_kinds([judged_on])
    if not uncompiled:
        refuse_unreachable(judged_on)
    isolation = isolating_layers(candidate)
    today = present_day() if waivers else None
    started = datetime.now(UTC)
    began = time.monotonic()
    count = workers or os.cpu_count() or 1
    how = CheckPlan(judged_on, _drive_from(candidate, drive), effort, seed, count, isolation)
    yield CheckStarted(candidate.name, None, how)
    counting = _counting(candidate, judged_on, fail_on, waivers)
    progress = _Progress(None if max_time is None else began + max_time, focus, counting)
    traces: tuple[dict[str, list[float]], ...] = ()
    behaviour: dict[str, Any] | None = None

    def ends() -> bool:
        return is_ended() or progress.is_overdue()

    if uncompiled:
        yield from _compile(uncompiled, judged_on, ends)
    work = planned_work(
        effort,
        seed,
        drive=judged_on,
        declaration=candidate.declaration,
        search=search,
        corpus=corpus,
        baseline=baseline,
        focus=focus,
    )
    prepared = judges_on(judged_on)
    with WorkerPool(candidate, workers=count, on_slow=on_slow, is_ended=ends, preparation=prepared) as pool:
        yield Running(sum(item.runs for item in work))
        try:
            yield from _run_all(pool, work, progress)
            if progress.complete and not progress.cuts_short():
                _repeat(pool, progress)
        except WorkEnded:
            progress.complete = False
            progress.end()
        runs = progress.all_runs
        judged = check_outcomes(
            runs,
            candidate.declaration,
            judged_on,
            complete=progress.complete and not progress.faults,
        )
        focus.require_judged(judged)
        outcomes = focus.outcomes(judged)
        try:
            outcomes = yield from _shrink(pool, outcomes, runs, effort, progress)
            outcomes = yield from _hear(pool, judged_on, outcomes, runs, progress, counts=contested == "fail")
            if not progress.cuts_short():
                yield Recording()
            outcomes, traces = _record(pool, outcomes, progress)
            behaviour = _behave(pool, judged_on, candidate.declaration, outcomes, progress)
        except WorkEnded:
            progress.end()
    _add_differing(outcomes, progress)
    if today is not None:
        outcomes = under_waivers(outcomes, candidate.name, waivers, today)
    comparisons = None if baseline is None else compared(baseline, runs, contract_of(judged_on).checks())
    if comparisons is not None:
        comparisons = tuple(entry for entry in comparisons if focus.judges(entry.check))
    timing: dict[str, Any] = {
        "started_utc": started.isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - began, 3),
        "workers": count,
        "machine": machine(),
        "checks": machine_dependent(runs),
    }
    result = _result(
        candidate, judged_on, effort, seed, outcomes, comparisons, traces, progress, timing, fail_on
    )
    steps = costly_steps(runs, candidate.step_limits)
    result = replace(result, behaviour=behaviour, contested=contested, steps=steps)
    yield CheckFinished(replace(result, drive_named=drive_named, isolation=isolation))


def _add_differing(outcomes: Sequence[CheckOutcome], progress: _Progress) -> None:
    """Make a fault of a repeated run that differed."""
    for outcome in outcomes:
        if outcome.id == REPEATED and outcome.verdict == "fail":
            message = f"the same scenario was answered differently when it was repeated: {outcome.measured}"
            progress.add_fault(Fault(FaultKind.NON_DETERMINISTIC, message, "step"))


def _drive_from(candidate: Candidate, named: DriveDocument | None) -> DriveFrom:
    if named is not None:
        return "user"
    return "default" if candidate.drive is None else "manifest"


def _compile(kinds: tuple[str, ...], drive: DriveDocument, is_ended: Callable[[], bool]) -> Iterator[Event]:
    yield Compiling(kinds)
    with suppress(WorkEnded):
        compile_kernels(kinds, is_ended)
        # Not sooner: it needs most of the kernels, which this process would compile alone.
        refuse_unreachable(drive)


def _run_all(pool: WorkerPool, work: Sequence[Work], progress: _Progress) -> Iterator[Event]:
    planned = sum(item.runs for item in work)
    mapped = pool.map([item.job for item in work])
    outcomes = _saved(mapped, work, progress)
    done = 0
    for item, outcome in zip(work, outcomes, strict=True):
        progress.add(item, outcome)
        # What was planned is the most there can be; the total becomes what there was.
        made = item.runs if isinstance(outcome, Fault) else len(outcome.runs)
        planned += made - item.runs
        done += made
        yield RunDone(done, planned, item.label, _worst(progress.all_runs, progress.focus))
        progress.stopped = progress.stops_here and item is not work[-1]
        if progress.stopped or (done < planned and progress.cuts_short()):
            progress.complete = False
            break


def _saved(
    outcomes: Iterator[ShardOutcome | Fault], work: Sequence[Work], progress: _Progress
) -> Iterator[ShardOutcome | Fault]:
    """Pass outcomes on; when work ends, add those that wait for an earlier one."""
    try:
        yield from outcomes
    except WorkEnded as ended:
        for index, outcome in sorted(ended.outcomes.items()):
            progress.add(work[index], outcome)
        raise


def _repeat(pool: WorkerPool, progress: _Progress) -> None:
    """Run once more, in processes of their own, what has been repeated within one."""
    for origin in (Origin.LAST_FAILED, Origin.FIXED, Origin.CORPUS):
        endings = list(repeated_elsewhere(pool, progress.runs[origin]))
        progress.runs[origin] = [ending for ending in endings if not isinstance(ending, Fault)]
        for ending in endings:
            if isinstance(ending, Fault):
                progress.add_fault(ending)


def _shrink(
    pool: WorkerPool,
    outcomes: tuple[CheckOutcome, ...],
    runs: Sequence[JudgedRun],
    effort: str,
    progress: _Progress,
) -> Generator[Event, None, tuple[CheckOutcome, ...]]:
    """Make the failures simpler, and return the outcomes with their counterexamples."""
    failures = simplest_failures(outcomes, runs)
    shrinking = [failure for failure in failures if failure.shrinks() and not progress.cuts_short()]
    shrunk: dict[str, Shrunk | Fault | None] = {}
    if shrinking:
        yield Shrinking("", 0, len(shrinking))
        endings = pool.map([failure.job(effort) for failure in shrinking])
        try:
            for failure, ending in zip(shrinking, endings, strict=True):
                shrunk[failure.check] = ending
                if isinstance(ending, Fault):
                    progress.add_fault(ending)
                yield Shrinking(failure.check, len(shrunk), len(shrinking))
                if len(shrunk) < len(shrinking) and progress.cuts_short():
                    break
        except WorkEnded as ended:
            shrunk |= {shrinking[index].check: ending for index, ending in ended.outcomes.items()}
            progress.end()
    return tuple(with_simplest(outcome, failures, shrunk) for outcome in outcomes)


def _hear(
    pool: WorkerPool,
    drive: DriveDocument,
    outcomes: tuple[CheckOutcome, ...],
    runs: Sequence[JudgedRun],
    progress: _Progress,
    *,
    counts: bool,
) -> Generator[Event, None, tuple[CheckOutcome, ...]]:
    """Run known good controllers where the candidate fails, and contest what none of them meets."""
    accused = accusations(outcomes, runs, drive)
    if accused and progress.cuts_short():
        accused = []
    endings: list[Acquittal | Defence | Fault] = []
    if accused:
        yield WitnessesHeard("", 0, len(accused))
    jobs: list[Job[Acquittal | Defence | Fault]] = [accusation.job() for accusation in accused]
    for accusation, ending in zip(accused, pool.map(jobs), strict=True):
        endings.append(ending)
        yield WitnessesHeard(accusation.check, len(endings), len(accused))
    return with_witnesses(outcomes, accused, endings, counts=counts)


def _record(
    pool: WorkerPool, outcomes: tuple[CheckOutcome, ...], progress: _Progress
) -> tuple[tuple[CheckOutcome, ...], tuple[dict[str, list[float]], ...]]:
    """Keep the signals of the runs that reports show."""
    plans = [] if progress.cuts_short() else recording_plans(outcomes)
    mapped = pool.map([recording_job(plan) for plan in plans])
    endings = list(mapped)
    for ending in endings:
        if isinstance(ending, Fault):
            progress.add_fault(ending)
    return with_recordings(outcomes, plans, endings)


def _behave(
    pool: WorkerPool,
    drive: DriveDocument,
    declaration: Declaration,
    outcomes: tuple[CheckOutcome, ...],
    progress: _Progress,
) -> dict[str, Any] | None:
    """Measure how a candidate without faults behaves, where all of it was judged."""
    job = behaviour_job(drive, declaration, outcomes)
    whole = progress.complete and not progress.faults and not progress.focus.only
    if job is None or not whole or progress.cuts_short():
        return None
    (ending,) = pool.map([job])
    if isinstance(ending, Fault):
        progress.add_fault(ending)
        return None
    return ending


def _result(
    candidate: Candidate,
    drive: DriveDocument,
    effort: str,
    seed: int,
    outcomes: tuple[CheckOutcome, ...],
    comparisons: tuple[BaselineComparison, ...] | None,
    traces: tuple[dict[str, list[float]], ...],
    progress: _Progress,
    timing: dict[str, Any],
    fail_on: str,
) -> CheckResult:
    verdict, exit_code = candidate_verdict(outcomes, progress.faults, comparisons or (), fail_on=fail_on)
    return CheckResult(
        candidate=candidate,
        drive=drive,
        verdict=verdict,
        exit_code=exit_code,
        seed=seed,
        effort=effort,
        checks=outcomes,
        faults=tuple(progress.faults),
        runs=len(progress.all_runs),
        infeasible=tuple(sorted(set(progress.infeasible), key=astuple)),
        provenance=provenance(),
        timing=timing,
        corpus_runs=len(progress.runs[Origin.CORPUS]),
        fixed=tuple(map(_fixed_margins, progress.runs[Origin.FIXED])),
        baseline=comparisons,
        fail_on=fail_on,
        traces=traces,
        focus=progress.focus.document(stopped=progress.stopped),
        incomplete=progress.incomplete,
    )


def _fixed_margins(run: JudgedRun) -> FixedMargins:
    margins = {margin.check: margin.value for margin in run.margins if margin.check not in _VOLATILE}
    return FixedMargins(str(run.scenario["name"]), run.scenario, margins)


def _worst(runs: Sequence[JudgedRun], focus: Focus) -> str:
    margins: list[Margin] = [
        margin
        for run in runs
        for margin in run.margins
        if margin.check in _TELLING
        and focus.judges(margin.check)
        and not margin.advisory
        and not (margin.met and margin.value == 0.0)
    ]
    if not margins:
        return ""
    least = min(margins, key=lambda margin: margin.value)
    return f"{least.check} {margin_in_words(least.value)}"
