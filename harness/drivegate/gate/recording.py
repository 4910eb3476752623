"""What a report shows of a run: its signals over time, few enough to be kept in the result document."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import checks_of, contract_of
from drivegate.contracts.recorded_trace import closeup_of, deciding_moment, shown_signals, thinned
from drivegate.drives.running import recorded
from drivegate.results.document import CheckSection, RecordingSection
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

_OF_STEPS: Final = "STP-1"
_MOST_ROWS: Final = 200_000


@dataclass(frozen=True)
class RecordPlan:
    scenario: dict[str, Any]
    checks: tuple[str, ...]
    failed: tuple[str, ...] = ()
    """Those of them whose counterexample it is."""


@dataclass(frozen=True)
class Recorded:
    columns: dict[str, list[float]]
    """Lists of equal length by the name of the column."""
    windows: dict[str, tuple[float, float]]
    """By check, start and end of the stretch that it was judged on (s)."""
    closeups: dict[str, Any]
    """By failed check, its deciding moment as plain data."""


def shown_scenario(outcome: CheckSection) -> dict[str, Any] | None:
    """Choose the run that a report shows for a check."""
    scenario = outcome.scenario if outcome.counterexample is None else outcome.counterexample
    return None if scenario is None or scenario.get("kind") == "script" else scenario


def recording_plans(outcomes: Iterable[CheckSection]) -> list[RecordPlan]:
    """Plan which runs are recorded: each scenario once, whatever number of checks look at it."""
    plans: list[RecordPlan] = []
    for outcome in outcomes:
        scenario = shown_scenario(outcome)
        if scenario is None:
            continue
        failed = () if outcome.counterexample is None else (outcome.id,)
        place = next((place for place, plan in enumerate(plans) if plan.scenario == scenario), None)
        if place is None:
            plans.append(RecordPlan(scenario, (outcome.id,), failed))
        else:
            known = plans[place]
            plans[place] = replace(known, checks=(*known.checks, outcome.id), failed=(*known.failed, *failed))
    return plans


def run_recorded(loaded: JudgedCandidate, plan: RecordPlan) -> Recorded:
    """Run a scenario again and keep its signals; this is what the worker process does."""
    scenario = parse_document(plan.scenario, Scenario, "the recorded scenario")
    every = -(-scenario.control_periods // _MOST_ROWS)
    keeps_steps = bool(plan.failed)
    record = recorded(loaded, scenario, loaded.controller(), trace_every=every, keeps_steps=keeps_steps)
    windows, closeups = {}, {}
    for check in checks_of(scenario.drive, loaded.candidate.declaration):
        if check.id in plan.checks:
            moment = deciding_moment(check, record, check.evaluate(record))
            windows[check.id] = (moment.start_s, moment.end_s)
            closeup = closeup_of(record, moment) if check.id in plan.failed else None
            if closeup is not None:
                closeups[check.id] = closeup
    return Recorded(thinned(shown_signals(record)), windows, closeups)


def with_recordings(
    outcomes: Iterable[CheckSection], endings: Iterable[Recorded | Fault]
) -> tuple[tuple[CheckSection, ...], tuple[dict[str, list[float]], ...]]:
    traces: list[dict[str, list[float]]] = []
    places: dict[str, RecordingSection] = {}
    for ending in endings:
        if isinstance(ending, Recorded):
            places |= {
                check: RecordingSection.model_construct(
                    trace=len(traces), start_s=start, end_s=end, closeup=ending.closeups.get(check)
                )
                for check, (start, end) in ending.windows.items()
            }
            traces.append(ending.columns)
    recorded_outcomes = (
        outcome.model_copy(update={"recording": places.get(outcome.id)}) for outcome in outcomes
    )
    return tuple(recorded_outcomes), tuple(traces)


@dataclass(frozen=True)
class BehaviourPlan:
    drive: DriveDocument
    step: dict[str, Any] | None
    """Scenario that shows how steps are followed, as plain data."""


def behaviour_job(
    drive: DriveDocument, declaration: Declaration, outcomes: Iterable[CheckSection]
) -> Job[dict[str, Any]] | None:
    """Plan the work; None where reports show nothing of the sort, or a candidate does not follow both references."""
    if not contract_of(drive).has_behaviour or len(declaration.references) == 1:
        return None
    step = next((shown_scenario(outcome) for outcome in outcomes if outcome.id == _OF_STEPS), None)
    return Job(run_behaviour, BehaviourPlan(drive, step))


def run_behaviour(loaded: JudgedCandidate, plan: BehaviourPlan) -> dict[str, Any]:
    """Run a candidate and measure how it behaves; this is what the worker process does."""
    step = None if plan.step is None else parse_document(plan.step, Scenario, "the scenario of steps")
    controller = loaded.controller()
    return contract_of(plan.drive).behaviour(
        lambda scenario: recorded(loaded, scenario, controller), plan.drive, step
    )
