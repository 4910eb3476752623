"""What a campaign has come to, as plain data, and its worst cases as files that can be run again."""

from __future__ import annotations

from typing import Any, Final

from drivegate.contracts.catalogue import check_of, on_drive
from drivegate.results.result import finite
from drivegate.studies.campaign.folder import CampaignFolder
from drivegate.studies.campaign.plan import CampaignPlan
from drivegate.studies.campaign.row import HARNESS_FAULT, SET_ASIDE
from drivegate.studies.campaign.statistics import (
    QUANTILES,
    CandidateStatistics,
    CheckStatistics,
    plain,
    statistics,
)
from drivegate.studies.campaign.worst_cases import fault_files, worst_case

SCHEMA: Final = 1
SUMMARY: Final = "summary.json"
KIND: Final = "campaign summary"


def summarised(plan: CampaignPlan, folder: CampaignFolder, confidence: float) -> dict[str, Any]:
    """Summarise a complete campaign, and write the summary and the worst cases into its folder."""
    found = statistics(plan, folder, confidence)
    document = {
        "schema": SCHEMA,
        "kind": KIND,
        "campaign": plan.campaign.name,
        "seed": plan.campaign.seed,
        "drives": {case.name: case.drive.identity() for case in plan.cases},
        "runs": plan.runs,
        "confidence": confidence,
        "quantiles": list(QUANTILES),
        "candidates": [_candidate(plan, folder, place, entry) for place, entry in enumerate(found)],
    }
    document = dict(finite(document))
    folder.write(folder.place / SUMMARY, folder.as_json(document))
    return document


def broken_harness(document: dict[str, Any]) -> bool:
    """Return True if the plant broke one of its own rules in some run."""
    return any(HARNESS_FAULT in candidate["verdicts"] for candidate in document["candidates"])


def _candidate(
    plan: CampaignPlan, folder: CampaignFolder, place: int, found: CandidateStatistics
) -> dict[str, Any]:
    candidate = plan.candidates[place]
    files = fault_files(plan, folder, found)
    return {
        "name": candidate.name,
        "kind": candidate.kind,
        "hash": candidate.content_hash,
        "verdicts": found.verdicts,
        "set_aside": found.verdicts.get(SET_ASIDE, 0),
        "not_passed": plain(found.violated),
        "cases": {case: plain(stated) for case, stated in found.cases.items()},
        "checks": [_check(plan, folder, place, entry) for entry in found.checks],
        "first_faults": [
            {"verdict": verdict, "run": run, "file": files[verdict]}
            for verdict, run in found.first_faults.items()
        ],
    }


def _check(plan: CampaignPlan, folder: CampaignFolder, place: int, entry: CheckStatistics) -> dict[str, Any]:
    drive = plan.run(entry.worst_run or 0).scenario.drive
    declaration = plan.candidates[place].declaration
    check = on_drive(check_of(drive.contract, entry.check), drive, declaration)
    return {
        "id": entry.check,
        "level": check.level,
        "subject": check.subject,
        "requirement": check.requirement,
        "limit": check.limit,
        **plain(entry.violated),
        "advisory_runs": entry.advised,
        "margin_quantiles": list(entry.quantiles),
        "margins": list(entry.curve),
        "worst_run": entry.worst_run,
        "worst_margin": entry.worst_margin,
        **worst_case(plan, folder, place, entry),
    }
