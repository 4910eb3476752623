"""Candidates compared on one drive: the plan, every candidate's runs, the best possible, and the document of it."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import ComparisonRequest, PlannedRun
from drivegate.gate.events import CheckStarted, Event
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.engine import Compared, find_best, named_candidates, prepared, run_plan
from drivegate.studies.compare.options import ComparisonOptions
from drivegate_cases.documents.wording import one_line
from drivegate_cases.scenario.reference import Reference
from drivegate_models.errors import InputError


@dataclass(frozen=True)
class ComparedDrive:
    """The outcome of a comparison on one drive."""

    request: ComparisonRequest
    """The drive, and how much was run on it."""
    plan: tuple[PlannedRun, ...]
    """What every candidate ran."""
    all_compared: list[Compared]
    """What has become of each candidate."""
    document: dict[str, Any] | None
    """The comparison document; None where no candidate could be run."""


def compared_on(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    request: ComparisonRequest,
    options: ComparisonOptions,
    display: Display,
    *,
    place: str = "",
) -> ComparedDrive:
    """Compare candidates on a drive; `place` is added to the titles of its progress."""
    started, began = present_day().isoformat(), time.monotonic()
    all_compared = named_candidates(specifications, resolved)
    request = replace(request, reference=_common_reference(all_compared))
    followed(prepared(request.drive), display)
    plan = contract_of(request.drive).comparison().plan(request)
    for compared in all_compared:
        if compared.error is None:
            try:
                runs = run_plan(
                    compared, plan, seed=request.seed, workers=options.workers, checks=options.checks
                )
                followed(_titled(runs, place), display)
            except Exception as error:
                # What fails stops no other candidate.
                compared.error = error
    if all(compared.error is not None for compared in all_compared):
        return ComparedDrive(request, plan, all_compared, None)
    best: dict[Any, Any] = {}
    followed(_titled(find_best(plan, options.workers, best), place), display)
    document = comparison_document(
        all_compared,
        plan,
        best,
        request,
        checks=options.checks,
        timing={"started_utc": started, "seconds": round(time.monotonic() - began, 3)},
    )
    return ComparedDrive(request, plan, all_compared, document)


def _common_reference(all_compared: Sequence[Compared]) -> Reference:
    """Choose what all candidates follow, a torque where they can; refuse those that follow the other alone."""
    candidates = [compared.candidate for compared in all_compared if compared.candidate is not None]
    reference: Reference = (
        "torque" if all("torque" in candidate.declaration.references for candidate in candidates) else "speed"
    )
    for compared in all_compared:
        if compared.candidate is None or reference in compared.candidate.declaration.references:
            continue
        compared.error = InputError(
            f"the candidate '{one_line(compared.candidate.name)}' follows no speed, which this comparison "
            "gives; compare candidates that follow the same"
        )
    return reference


def _titled(events: Iterable[Event], place: str) -> Iterator[Event]:
    """Add a place to the title of what begins."""
    for event in events:
        if place and isinstance(event, CheckStarted):
            yield replace(event, candidate_name=f"{event.candidate_name}{place}")
        else:
            yield event
