"""Candidates compared on one drive: the options, the plan, every candidate's runs, and the best possible."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import ComparisonRequest, PlannedRun
from drivegate.gate.events import CheckStarted, Event
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.engine import Compared, find_best, named_candidates, run_plan
from drivegate_cases.documents.wording import one_line
from drivegate_cases.scenario.reference import Reference
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

DEFAULT_CYCLE: Final = "ece-15"
"""Drive cycle where none is named."""


@dataclass(frozen=True)
class ComparisonOptions:
    """How much is compared, and on what."""

    effort: str = "default"
    """``quick``, ``default`` or ``nightly``."""
    stated_seed: int | None = None
    """Seed of everything drawn, where one is stated."""
    workers: int | None = None
    """Number of processes; None for as many as there are processors."""
    checks: bool = True
    """Whether the checks are made as well."""
    cycle: str | None = None
    """Name or file of the drive cycle; None for the default."""

    @property
    def seed(self) -> int:
        """Seed of everything drawn."""
        return self.stated_seed or 0

    def refuse_unused(self, drive: DriveDocument) -> None:
        """Refuse an option that changes nothing in a comparison on a drive."""
        ignores = contract_of(drive).comparison().ignores
        if not ignores:
            return
        because = f"the drive '{one_line(drive.name)}' takes {ANSWERS[drive.contract]}, and {ignores}"
        if self.cycle is not None:
            raise InputError(f"--cycle has no effect, since {because}; leave it out")
        if self.stated_seed is not None and not self.checks:
            raise InputError(
                f"--seed has no effect with --no-checks, since {because}; leave out one of the two"
            )


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
    # It brings pandas, which candidates that are refused do not need.
    from drivegate.studies.compare.document import comparison_document

    started, began = present_day().isoformat(), time.monotonic()
    all_compared = named_candidates(specifications, resolved)
    request = replace(request, reference=_common_reference(all_compared))
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
        why = (
            "follows a q current alone, but a comparison gives speeds or torques; drivegate diff shows where two such "
            "candidates part"
            if compared.candidate.declaration.follows_current
            else "follows no speed, which this comparison gives; compare candidates that follow the same"
        )
        compared.error = InputError(f"the candidate '{one_line(compared.candidate.name)}' {why}")
    return reference


def _titled(events: Iterable[Event], place: str) -> Iterator[Event]:
    """Add a place to the title of what begins."""
    for event in events:
        if place and isinstance(event, CheckStarted):
            yield replace(event, candidate_name=f"{event.candidate_name}{place}")
        else:
            yield event
