"""Candidates compared on one drive: the plan, every candidate's runs, the best possible, and the document of it."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.gate.events import CheckStarted, Event
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.engine import (
    Compared,
    Refused,
    named_candidates,
    prepared,
    refused_of,
    run_plan,
    solve_plan,
)
from drivegate.studies.compare.options import ComparisonOptions
from drivegate.studies.compare.plan import PlannedRun, planned_runs
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.drive_cycle import DriveCycle


@dataclass(frozen=True)
class ComparedDrive:
    """What the candidates came to on one drive.

    Attributes
    ----------
    drive : DriveDocument
        The drive.
    plan : tuple of PlannedRun
        What every candidate ran.
    all_compared : list of Compared
        What has become of each candidate.
    document : dict or None
        The comparison document; None where no candidate could be run.
    """

    drive: DriveDocument
    plan: tuple[PlannedRun, ...]
    all_compared: list[Compared]
    document: dict[str, Any] | None

    @property
    def refused(self) -> Refused:
        """Specification and error of each candidate that could not be compared."""
        return refused_of(self.all_compared)


def compared_on(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    cycle: DriveCycle,
    drive: DriveDocument,
    options: ComparisonOptions,
    display: Display,
    *,
    place: str = "",
) -> ComparedDrive:
    """Compare candidates on a drive; `place` is added to the titles of its progress."""
    started, began = present_day().isoformat(), time.monotonic()
    all_compared = named_candidates(specifications, resolved)
    followed(prepared(drive), display)
    plan = planned_runs(drive, cycle, options.effort, options.seed)
    for compared in all_compared:
        if compared.error is not None:
            continue
        try:
            runs = run_plan(compared, plan, seed=options.seed, workers=options.workers, checks=options.checks)
            followed(_titled(runs, place), display)
        except Exception as error:
            compared.error = error
    if all(compared.error is not None for compared in all_compared):
        return ComparedDrive(drive, plan, all_compared, None)
    oracle: dict[str, Any] = {}
    followed(_titled(solve_plan(plan, options.workers, oracle), place), display)
    document = comparison_document(
        all_compared,
        plan,
        oracle,
        drive=drive,
        cycle=cycle,
        effort=options.effort,
        seed=options.seed,
        checks=options.checks,
        timing={"started_utc": started, "seconds": round(time.monotonic() - began, 3)},
    )
    return ComparedDrive(drive, plan, all_compared, document)


def _titled(events: Iterable[Event], place: str) -> Iterator[Event]:
    """Add to the title of what begins."""
    for event in events:
        if place and isinstance(event, CheckStarted):
            yield replace(event, candidate_name=f"{event.candidate_name}{place}")
        else:
            yield event
