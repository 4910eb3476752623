"""Controllers of duty ratios compared on one drive: every candidate's runs and checks, and the document of it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display
from drivegate.results.waivers import present_day
from drivegate.studies.compare.duty.document import duty_document
from drivegate.studies.compare.duty.plan import planned_duty_runs
from drivegate.studies.compare.duty.run import measured_duty
from drivegate.studies.compare.engine import Refused, named_candidates, prepared, refused_of, run_plan
from drivegate.studies.compare.options import ComparisonOptions
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def duty_compared_on(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    drive: PmAcDocument,
    options: ComparisonOptions,
    display: Display,
) -> tuple[dict[str, Any] | None, Refused]:
    """Compare candidates on a drive, and tell who was refused; no document where none of them could be run."""
    started, began = present_day().isoformat(), time.monotonic()
    all_compared = named_candidates(specifications, resolved)
    followed(prepared(drive), display)
    plan = planned_duty_runs(drive, options.effort)
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
                measure=measured_duty,
                time_step=None,
            )
            followed(runs, display)
        except Exception as error:
            compared.error = error
    if all(compared.error is not None for compared in all_compared):
        return None, refused_of(all_compared)
    document = duty_document(
        all_compared,
        plan,
        drive=drive,
        effort=options.effort,
        seed=options.seed,
        checks=options.checks,
        timing={"started_utc": started, "seconds": round(time.monotonic() - began, 3)},
    )
    return document, refused_of(all_compared)
