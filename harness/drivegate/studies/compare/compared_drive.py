"""Candidates compared on one drive: the plan, every candidate's runs, the best possible, and the document of it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.candidate_runs import run_candidates, titled
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.engine import (
    Compared,
    Planned,
    Refused,
    named_candidates,
    prepared,
    refused_of,
    solve_plan,
)
from drivegate.studies.compare.options import ComparisonOptions
from drivegate.studies.compare.plan import planned_runs
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.drive_cycle import DriveCycle


@dataclass(frozen=True)
class ComparedDrive:
    """What the candidates came to on one drive."""

    drive: DriveDocument
    """The drive."""
    plan: tuple[Planned, ...]
    """What every candidate ran, as its contract has it."""
    all_compared: list[Compared]
    """What has become of each candidate."""
    document: dict[str, Any] | None
    """The comparison document; None where no candidate could be run."""

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
    if not run_candidates(all_compared, plan, options, display, place=place):
        return ComparedDrive(drive, plan, all_compared, None)
    oracle: dict[str, Any] = {}
    followed(titled(solve_plan(plan, options.workers, oracle), place), display)
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
