"""The runs of all candidates of a comparison on one drive, followed on the display."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from drivegate.containment.messages import JudgedCandidate
from drivegate.gate.events import CheckStarted, Event
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.studies.compare.engine import Compared, Planned, run_plan
from drivegate.studies.compare.options import ComparisonOptions
from drivegate.studies.compare.run import Figures, measured, timed


def run_candidates(
    all_compared: Sequence[Compared],
    plan: Sequence[Planned],
    options: ComparisonOptions,
    display: Display,
    *,
    place: str = "",
    measure: Callable[[JudgedCandidate, Any], Figures] = measured,
    time_step: Callable[[JudgedCandidate, Any], dict[str, Any]] | None = timed,
) -> bool:
    """Run every candidate that is not refused through a plan; what fails is kept with it and stops no other.

    Whether any could be run is the answer; `place` is added to the titles of the progress.
    """
    for compared in all_compared:
        if compared.error is not None:
            continue
        try:
            runs = run_plan(
                compared,
                plan,
                seed=options.seed,
                workers=options.workers,
                checks=options.checks,
                measure=measure,
                time_step=time_step,
            )
            followed(titled(runs, place), display)
        except Exception as error:
            compared.error = error
    return any(compared.error is None for compared in all_compared)


def titled(events: Iterable[Event], place: str) -> Iterator[Event]:
    """Add a place to the title of what begins."""
    for event in events:
        if place and isinstance(event, CheckStarted):
            yield replace(event, candidate_name=f"{event.candidate_name}{place}")
        else:
            yield event
