"""The check of a candidate: plan, work in contained processes, verdict. It reports what it does as events."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass, replace
from datetime import UTC, date, datetime
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS, untimed_because
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin, margin_in_words
from drivegate.containment.candidate_isolation import isolating_layers
from drivegate.containment.machine_memory import usual_workers
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkEnded, WorkerPool
from drivegate.contracts.catalogue import all_checks, all_contracts, applicable_checks, checks_of
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
from drivegate.gate.fault_shrinking import fault_job, shrinks, with_simplest_faults
from drivegate.gate.options import CheckOptions
from drivegate.gate.own_requirements import require_fitting, with_evidence, with_requirements
from drivegate.gate.plan import EXAMPLES, REPEATED, Origin, Work, planned_work
from drivegate.gate.progress import Progress
from drivegate.gate.recording import behaviour_job, recording_plans, run_recorded, with_recordings
from drivegate.gate.repetition import repeated_elsewhere
from drivegate.gate.same_drive import require_same_drive
from drivegate.gate.shard import searched_checks
from drivegate.gate.shrinking import Shrunk, simplest_failures, with_simplest
from drivegate.gate.warm_up import compile_kernels, judges_on, uncompiled_kinds
from drivegate.gate.witnesses import Acquittal, Defence, accusations, with_witnesses
from drivegate.results.baseline import compared
from drivegate.results.document import (
    CandidateSection,
    CheckSection,
    ComparisonSection,
    DriveSection,
    FaultSection,
    FixedSection,
    FocusSection,
    InfeasibleSection,
    ResultDocument,
    RunSection,
)
from drivegate.results.provenance import hash_of_scenario, machine, provenance
from drivegate.results.result import counted_levels
from drivegate.results.verdict import candidate_verdict, check_outcomes, costly_steps, machine_dependent
from drivegate.results.waivers import present_day, under_waivers
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import HarnessFault, InputError

_SHOWN: Final = frozenset(check for contract in all_contracts() for check in searched_checks(contract.checks))
"""Checks whose margins progress shows; one of 0 that is met is a clamped command's."""
_VOLATILE: Final = frozenset(check.id for check in all_checks().values() if check.volatile)


@dataclass(frozen=True)
class _Plan:
    """A check of which all is known that can be before anything is compiled or run."""

    candidate: Candidate
    options: CheckOptions
    """With the focus that suits the drive."""
    how: CheckPlan
    uncompiled: tuple[str, ...]
    """Kinds of drives whose kernels are compiled first."""
    today: date | None
    """The day on which waivers must hold."""


def check_candidate(candidate: Candidate, options: CheckOptions) -> Iterator[Event]:
    """Check a candidate on a drive, and report progress as events."""
    plan = _planned(with_requirements(candidate, options.requirements), options)
    started, began = datetime.now(UTC), time.monotonic()
    yield CheckStarted(plan.candidate.name, None, plan.how)
    deadline = None if options.max_time is None else began + options.max_time
    progress = Progress(deadline, plan.options.focus, _counting(plan))
    yield from _run(plan, progress)
    timing = {
        "started_utc": started.isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - began, 3),
        "workers": plan.how.workers,
        "machine": machine(),
        "checks": machine_dependent(progress.all_runs),
    }
    comparisons, failure = _compared(plan, progress.all_runs)
    yield CheckFinished(_finished(plan, progress, comparisons, timing))
    if failure is not None:
        raise failure


def _planned(candidate: Candidate, options: CheckOptions) -> _Plan:
    """Refuse what cannot be checked, as far as it is known before anything is compiled or run."""
    if options.effort not in EXAMPLES:
        raise InputError(f"the effort is '{options.effort}', but must be one of {', '.join(EXAMPLES)}")
    if options.seed < 0:
        raise InputError(f"the seed is {options.seed}, but must be 0 or more")
    drive = drive_for(candidate, options.drive)
    require_same_drive(
        drive,
        baseline=options.baseline,
        counterexamples=(*options.focus.first, *options.corpus),
        waivers=[waiver for waiver in options.waivers if waiver.candidate == candidate.name],
    )
    own = checks_of(drive, candidate.declaration)
    require_fitting(candidate.declaration, drive)
    focus = options.focus.within(drive.contract, [check.id for check in own])
    # What a candidate does not declare is known before anything is compiled or run.
    focus.require_judged(
        check_outcomes(
            (), candidate.declaration, drive, complete=False, untimed_because=untimed_because(candidate)
        )
    )
    uncompiled = uncompiled_kinds([drive])
    # The oracle needs compiled kernels. With a cold cache `_compile` refuses the drive once workers have made them.
    if not uncompiled:
        refuse_unreachable(drive)
    drive_from: DriveFrom = "default" if candidate.drive is None else "manifest"
    how = CheckPlan(
        drive,
        drive_from if options.drive is None else "user",
        options.effort,
        options.seed,
        options.workers or usual_workers(),
        isolating_layers(candidate),
    )
    today = present_day() if options.waivers else None
    return _Plan(candidate, replace(options, focus=focus), how, uncompiled, today)


def _counting(plan: _Plan) -> frozenset[str]:
    """Return the identifiers of the checks that can fail the candidate."""
    options = plan.options
    levels = counted_levels(options.fail_on)
    waived = {waiver.check for waiver in options.waivers if waiver.candidate == plan.candidate.name}
    drive, declaration = plan.how.drive, plan.candidate.declaration
    own = applicable_checks(drive, declaration)
    return frozenset(check.id for check in own if check.level in levels) - waived


def _run(plan: _Plan, progress: Progress) -> Iterator[Event]:
    """Make all runs, judge them, and find out what reports show of failures."""
    candidate, options, drive = plan.candidate, plan.options, plan.how.drive

    def ends() -> bool:
        return options.is_ended() or progress.is_overdue()

    if plan.uncompiled:
        yield from _compile(plan.uncompiled, drive, ends)
    work = planned_work(
        options.effort,
        options.seed,
        drive=drive,
        declaration=candidate.declaration,
        search=options.search,
        corpus=options.corpus,
        baseline=options.baseline,
        focus=options.focus,
        content_hash="" if KINDS[candidate.kind].is_included else candidate.content_hash,
    )
    prepared = judges_on(drive)
    with WorkerPool(
        candidate, workers=plan.how.workers, on_slow=options.on_slow, is_ended=ends, preparation=prepared
    ) as pool:
        yield Running(sum(item.runs for item in work))
        try:
            yield from _run_all(pool, work, progress)
            # Last, since repetitions of a few runs say little about a candidate whose own runs were cut short.
            if progress.complete and not progress.cuts_short():
                _repeat(pool, progress)
        except WorkEnded:
            # What was judged by then is reported: a failure is not witnessed yet, and a check that was met so far is
            # inconclusive.
            progress.complete = False
            progress.end()
        complete = progress.complete and not progress.faults
        judged = check_outcomes(
            progress.all_runs,
            candidate.declaration,
            drive,
            complete=complete,
            untimed_because=untimed_because(candidate),
        )
        options.focus.require_judged(judged)
        progress.outcomes = options.focus.outcomes(judged)
        try:
            # Witnesses run in the counterexample as it was shrunk, and recordings show the run that they settled on.
            yield from _shrink(pool, options.effort, progress)
            _shrink_faults(pool, options.effort, progress)
            yield from _hear(pool, drive, progress, counts=options.contested == "fail")
            if not progress.cuts_short():
                yield Recording()
            _record(pool, progress)
            _behave(pool, drive, candidate.declaration, progress)
        except WorkEnded:
            progress.end()


def _finished(
    plan: _Plan,
    progress: Progress,
    comparisons: tuple[ComparisonSection, ...] | None,
    timing: dict[str, Any],
) -> ResultDocument:
    candidate, options, how, runs = plan.candidate, plan.options, plan.how, progress.all_runs
    outcomes = progress.outcomes
    _add_differing(outcomes, progress)
    if plan.today is not None:
        outcomes = under_waivers(outcomes, candidate.name, options.waivers, plan.today)
    outcomes = with_evidence(outcomes, candidate.declaration)
    verdict, exit_code = candidate_verdict(
        outcomes, progress.faults, comparisons or (), fail_on=options.fail_on
    )
    # Sorted, since workers finish in any order; shards may set aside the same scenario.
    infeasible = sorted(set(progress.infeasible), key=astuple)
    confined = bool(options.focus.only) or progress.stopped
    made: dict[str, Any] = {
        "isolation": how.isolation,
        "traces": progress.traces,
        "behaviour": progress.behaviour,
        # Which run comes first in a process depends on the number of workers.
        "remarks": tuple(sorted({remark for run in runs for remark in run.remarks})),
        "steps": costly_steps(runs, candidate.step_limits),
        "provenance": provenance(),
        "timing": timing,
    }
    return ResultDocument.model_construct(
        kind="check",
        candidate=CandidateSection.of(candidate),
        drive=DriveSection.of(how.drive, options.drive_named),
        verdict=verdict,
        exit_code=exit_code,
        seed=how.seed,
        effort=how.effort,
        judged_by="own code" if KINDS[candidate.kind].is_included else "playback",
        fail_on=options.fail_on,
        contested=options.contested,
        focus=FocusSection(only=options.focus.only, stopped_at_first=progress.stopped) if confined else None,
        incomplete=progress.incomplete,
        checks=outcomes,
        faults=tuple(map(FaultSection.of, progress.faults)),
        runs=len(runs),
        set_aside=len(infeasible),
        infeasible=tuple(InfeasibleSection(scenario=one.scenario, reason=one.reason) for one in infeasible),
        corpus_runs=len(progress.runs[Origin.CORPUS]),
        fixed=tuple(map(_fixed_margins, progress.runs[Origin.FIXED])),
        run_list=tuple(map(_listed, runs)),
        baseline=comparisons,
        **made,
    )


def _compared(
    plan: _Plan, runs: Sequence[JudgedRun]
) -> tuple[tuple[ComparisonSection, ...] | None, HarnessFault | None]:
    """Compare with the baseline; a failure of that is returned, since the result of the runs is not lost with it."""
    options = plan.options
    if options.baseline is None:
        return None, None
    checks = checks_of(plan.how.drive, plan.candidate.declaration)
    try:
        entries = compared(options.baseline, runs, checks)
    except Exception as error:
        failure = HarnessFault(
            f"the comparison with the baseline failed ({type(error).__name__}: {error}), and the result has none"
        )
        failure.__cause__ = error
        return None, failure
    return tuple(entry for entry in entries if options.focus.judges(entry.check)), None


def _add_differing(outcomes: Sequence[CheckSection], progress: Progress) -> None:
    """Make a fault of a repeated run that differed."""
    for outcome in outcomes:
        if outcome.id == REPEATED and outcome.verdict == "fail":
            message = f"the same scenario was answered differently when it was repeated: {outcome.measured}"
            progress.add_fault(Fault(FaultKind.NON_DETERMINISTIC, message, "step"))


def _compile(kinds: tuple[str, ...], drive: DriveDocument, is_ended: Callable[[], bool]) -> Iterator[Event]:
    yield Compiling(kinds)
    with suppress(WorkEnded):
        compile_kernels(kinds, is_ended)
        # Not sooner: it needs most of the kernels, which this process would compile alone.
        refuse_unreachable(drive)


def _run_all(pool: WorkerPool, work: Sequence[Work], progress: Progress) -> Iterator[Event]:
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
        yield RunDone(done, planned, item.label, _worst(progress))
        progress.stopped = progress.stops_here and item is not work[-1]
        if progress.stopped or (done < planned and progress.cuts_short()):
            progress.complete = False
            break


def _saved(
    outcomes: Iterator[ShardOutcome | Fault], work: Sequence[Work], progress: Progress
) -> Iterator[ShardOutcome | Fault]:
    """Pass outcomes on; when work ends, add those that wait for an earlier one."""
    try:
        yield from outcomes
    except WorkEnded as ended:
        for index, outcome in sorted(ended.outcomes.items()):
            progress.add(work[index], outcome)
        raise


def _repeat(pool: WorkerPool, progress: Progress) -> None:
    """Run once more, in processes of their own, what has been repeated within one."""
    for origin in (Origin.LAST_FAILED, Origin.FIXED, Origin.CORPUS):
        endings = list(repeated_elsewhere(pool, progress.runs[origin]))
        progress.runs[origin] = [ending for ending in endings if not isinstance(ending, Fault)]
        for ending in endings:
            progress.add_fault(ending)


def _shrink(pool: WorkerPool, effort: str, progress: Progress) -> Iterator[Event]:
    failures = simplest_failures(progress.outcomes, progress.all_runs)
    shrinking = [failure for failure in failures if failure.shrinks() and not progress.cuts_short()]
    shrunk: dict[str, Shrunk | Fault | None] = {}
    if shrinking:
        yield Shrinking("", 0, len(shrinking))
        endings = pool.map([failure.job(effort) for failure in shrinking])
        try:
            for failure, ending in zip(shrinking, endings, strict=True):
                shrunk[failure.check] = ending
                progress.add_fault(ending)
                yield Shrinking(failure.check, len(shrunk), len(shrinking))
                if len(shrunk) < len(shrinking) and progress.cuts_short():
                    break
        except WorkEnded as ended:
            shrunk |= {shrinking[index].check: ending for index, ending in ended.outcomes.items()}
            progress.end()
    progress.outcomes = with_simplest(progress.outcomes, failures, shrunk)


def _shrink_faults(pool: WorkerPool, effort: str, progress: Progress) -> None:
    """Look for the simplest scenario in which a sanitizer reports the same."""
    places = [place for place, fault in enumerate(progress.faults) if shrinks(fault)]
    if not places or progress.cuts_short():
        return
    mapped = pool.map([fault_job(progress.faults[place], effort) for place in places])
    endings = dict(zip(places, list(mapped), strict=True))
    progress.faults = with_simplest_faults(progress.faults, endings)


def _hear(pool: WorkerPool, drive: DriveDocument, progress: Progress, *, counts: bool) -> Iterator[Event]:
    """Run known good controllers where the candidate fails; contest what none of them meets, and note what is left."""
    accused = accusations(progress.outcomes, progress.all_runs, drive)
    heard: dict[str, Acquittal | Defence | Fault] = {}
    if accused and not progress.cuts_short():
        yield WitnessesHeard("", 0, len(accused))
        endings = pool.map([accusation.job() for accusation in accused])
        try:
            for accusation, ending in zip(accused, endings, strict=True):
                heard[accusation.check] = ending
                yield WitnessesHeard(accusation.check, len(heard), len(accused))
        except WorkEnded as ended:
            heard |= {accused[index].check: ending for index, ending in ended.outcomes.items()}
            progress.end()
    endings_of = {accusation.check: (accusation, heard.get(accusation.check)) for accusation in accused}
    progress.outcomes = with_witnesses(progress.outcomes, endings_of, counts=counts)


def _record(pool: WorkerPool, progress: Progress) -> None:
    plans = [] if progress.cuts_short() else recording_plans(progress.outcomes)
    mapped = pool.map([Job(run_recorded, plan) for plan in plans])
    endings = list(mapped)
    for ending in endings:
        progress.add_fault(ending)
    progress.outcomes, progress.traces = with_recordings(progress.outcomes, endings)


def _behave(pool: WorkerPool, drive: DriveDocument, declaration: Declaration, progress: Progress) -> None:
    """Measure how a candidate without faults behaves, where all of it was judged."""
    job = behaviour_job(drive, declaration, progress.outcomes)
    whole = progress.complete and not progress.faults and not progress.focus.only
    if job is None or not whole or progress.cuts_short():
        return
    (ending,) = pool.map([job])
    progress.add_fault(ending)
    progress.behaviour = None if isinstance(ending, Fault) else ending


def _fixed_margins(run: JudgedRun) -> FixedSection:
    return FixedSection.model_construct(
        name=str(run.scenario["name"]), scenario=run.scenario, margins=_settled_margins(run)
    )


def _listed(run: JudgedRun) -> RunSection:
    return RunSection.model_construct(
        name=str(run.scenario["name"]),
        # Nothing is random in a script.
        seed=int(run.scenario.get("seed", 0)),
        hash=hash_of_scenario(run.scenario),
        margins=_settled_margins(run),
    )


def _settled_margins(run: JudgedRun) -> dict[str, float | None]:
    """Return the margins of a run by check, without those that depend on the machine."""
    return {margin.check: margin.value for margin in run.margins if margin.check not in _VOLATILE}


def _worst(progress: Progress) -> str:
    margins: list[Margin] = [
        margin
        for run in progress.all_runs
        for margin in run.margins
        if (margin.check in _SHOWN or margin.check not in all_checks())
        and margin.check in progress.counting
        and progress.focus.judges(margin.check)
        and not margin.advisory
        and not (margin.met and margin.value == 0.0)
    ]
    if not margins:
        return ""
    least = min(margins, key=lambda margin: margin.value)
    return f"{least.check} {margin_in_words(least.value)}"
