"""Controllers of duty ratios compared on one drive: every candidate's runs and checks, and the document of it."""

from __future__ import annotations

import time
from collections.abc import Sequence

from drivegate.candidates.candidate import Candidate
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.candidate_runs import run_candidates
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.duty.document import duty_document
from drivegate.studies.compare.duty.plan import planned_duty_runs
from drivegate.studies.compare.duty.run import measured_duty
from drivegate.studies.compare.engine import Compared, named_candidates, prepared
from drivegate.studies.compare.options import ComparisonOptions
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.reference import Reference
from drivegate_models.errors import InputError


def duty_compared_on(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    drive: PmAcDocument,
    options: ComparisonOptions,
    display: Display,
    *,
    place: str = "",
) -> ComparedDrive:
    """Compare candidates on a drive; `place` is added to the titles of its progress."""
    started, began = present_day().isoformat(), time.monotonic()
    all_compared = named_candidates(specifications, resolved)
    followed(prepared(drive), display)
    reference = _common_reference(all_compared)
    plan = planned_duty_runs(drive, options.effort, reference)
    if not run_candidates(
        all_compared, plan, options, display, place=place, measure=measured_duty, time_step=None
    ):
        return ComparedDrive(drive, plan, all_compared, None)
    document = duty_document(
        all_compared,
        plan,
        drive=drive,
        reference=reference,
        effort=options.effort,
        seed=options.seed,
        checks=options.checks,
        timing={"started_utc": started, "seconds": round(time.monotonic() - began, 3)},
    )
    return ComparedDrive(drive, plan, all_compared, document)


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
            f"the candidate '{one_line(compared.candidate.name)}' follows a torque alone, but another one a speed "
            "alone; compare candidates that follow the same"
        )
    return reference
