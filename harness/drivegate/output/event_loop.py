"""Following the events of a check or a comparison: each is shown, and the last one has the result."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from drivegate.gate.events import CheckFinished, CheckStarted, Event, RunDone, Shrinking, WitnessesHeard
from drivegate.output.pace import CheckPace
from drivegate.output.progress import Display
from drivegate.results.result import CheckResult
from drivegate_models.errors import HarnessFault


def followed(events: Iterable[Event], display: Display) -> CheckResult | None:
    """Show every event, and give the result if they end with one."""
    result: CheckResult | None = None
    for event in events:
        _show(event, display)
        if isinstance(event, CheckFinished):
            result = event.result
    return result


def _with_pace(events: Iterable[Event], display: Display, pace: CheckPace) -> Iterator[Event]:
    """Tell of a check that will take hours, as its events go by."""
    for event in events:
        if isinstance(event, RunDone) and (words := pace.slow_in_words(event.done, event.planned)):
            display.announce(words)
        yield event


def finished(events: Iterable[Event], display: Display) -> CheckResult:
    """Show every event of a check, and give its result; tell if it will take hours."""
    result = followed(_with_pace(events, display, CheckPace()), display)
    if result is None:
        raise HarnessFault("the check ended without a result")
    return result


def _show(event: Event, display: Display) -> None:
    if isinstance(event, CheckStarted):
        display.begin(event.candidate_name, event.planned_runs)
    elif isinstance(event, RunDone):
        worst = f"least margin so far {event.worst}" if event.worst else ""
        told = (worst, display.time_left(event.done, event.planned))
        display.advance(event.done, event.planned, ", ".join(filter(None, told)), unit="runs")
    elif isinstance(event, Shrinking):
        display.remark(f"shrinking counterexamples: {event.done} of {event.planned}")
    elif isinstance(event, WitnessesHeard):
        display.remark(f"running known good controllers in counterexamples: {event.done} of {event.planned}")
    elif isinstance(event, CheckFinished):
        display.remark(f"{event.result.runs} runs made, {event.result.verdict}", always=True)
