"""Following the events of a check or a comparison: each is shown, and the last one has the result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from drivegate.contracts.catalogue import contract_of
from drivegate.gate.events import (
    CheckFinished,
    CheckPlan,
    CheckStarted,
    Compiling,
    Event,
    Recording,
    RunDone,
    Running,
    Shrinking,
    WitnessesHeard,
)
from drivegate.isolation.layers import layers_in_words
from drivegate.output.progress import Display
from drivegate.output.waiting import CheckPace, compiling_in_words
from drivegate_models.errors import HarnessFault

if TYPE_CHECKING:
    from drivegate.results.document import ResultDocument


def followed(
    events: Iterable[Event], display: Display, keep: Callable[[ResultDocument], None] = lambda _: None
) -> ResultDocument | None:
    """Show every event, and return the result if they end with one; `keep` gets it first, whatever fails after it."""
    result: ResultDocument | None = None
    for event in events:
        _show(event, display)
        if isinstance(event, CheckFinished):
            result = event.result
            keep(result)
    return result


def _with_pace(events: Iterable[Event], display: Display, pace: CheckPace) -> Iterator[Event]:
    """Describe a check that will take hours, as its events go by."""
    workers = 1
    for event in events:
        if isinstance(event, CheckStarted) and event.plan is not None:
            workers = event.plan.workers
        if isinstance(event, Running):
            pace.begin(event.planned_runs, workers)
        if isinstance(event, RunDone) and (words := pace.slow_in_words(event.done, event.planned)):
            display.announce(words)
        yield event


def finished(
    events: Iterable[Event],
    display: Display,
    pace: CheckPace | None = None,
    keep: Callable[[ResultDocument], None] = lambda _: None,
) -> ResultDocument:
    """Show every event of a check, and return its result, as `followed` does; announce if it will take long."""
    result = followed(_with_pace(events, display, pace or CheckPace()), display, keep)
    if result is None:
        raise HarnessFault("the check ended without a result")
    return result


def _show(event: Event, display: Display) -> None:
    if isinstance(event, CheckStarted):
        if event.plan is not None:
            display.headline(_headline(event.candidate_name, event.plan))
        display.begin(event.candidate_name, event.planned_runs)
        if event.plan is None:
            display.phase("running")
    elif isinstance(event, Compiling):
        display.phase(compiling_in_words(event.kinds))
    elif isinstance(event, Running):
        display.phase("running")
    elif isinstance(event, RunDone):
        worst = f"least margin so far {event.worst}" if event.worst else ""
        parts = (worst, display.time_left(event.done, event.planned))
        display.advance(event.done, event.planned, ", ".join(filter(None, parts)), unit="runs")
    elif isinstance(event, Shrinking):
        display.phase("shrinking counterexamples", event.done, event.planned)
    elif isinstance(event, WitnessesHeard):
        display.phase("running known good controllers in counterexamples", event.done, event.planned)
    elif isinstance(event, Recording):
        display.phase("recording what the report shows")


def _headline(name: str, plan: CheckPlan) -> str:
    chosen = {
        "user": "",
        "manifest": " (from its manifest)",
        "default": f" (default for {contract_of(plan.drive).candidates})",
    }
    isolated = "" if plan.isolation is None else f", {layers_in_words(plan.isolation)}"
    return (
        f"{name} on {plan.drive.name}{chosen[plan.drive_from]}, contract {plan.drive.contract}, "
        f"effort {plan.effort}, seed {plan.seed}{isolated}"
    )
