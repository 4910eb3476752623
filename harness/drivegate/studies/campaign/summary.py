"""What a campaign has come to, as plain data, and its worst cases as files that can be run again."""

from __future__ import annotations

from typing import Any, Final
from urllib.parse import quote

from drivegate.candidates.fault import bounded_line
from drivegate.checks.catalogue import CHECKS
from drivegate.results.counterexample import KIND, Counterexample
from drivegate.results.provenance import versions
from drivegate.results.result import finite
from drivegate.scenarios.size import size_of
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
from drivegate.studies.campaign.table import columns_of
from drivegate_cases.documents.document import parse_document

SCHEMA: Final = 1
SUMMARY: Final = "summary.json"
COUNTEREXAMPLES: Final = "counterexamples"
FAULTS: Final = "faults"

_BY_ID = {check.id: check for check in CHECKS}


def summarised(plan: CampaignPlan, folder: CampaignFolder, confidence: float) -> dict[str, Any]:
    """Summarise a complete campaign, and write the summary and the worst cases into its folder."""
    found = statistics(plan, folder, confidence)
    document = {
        "schema": SCHEMA,
        "kind": "campaign summary",
        "campaign": plan.campaign.name,
        "seed": plan.campaign.seed,
        "runs": plan.runs,
        "confidence": confidence,
        "quantiles": list(QUANTILES),
        "candidates": [_candidate(plan, folder, place, entry) for place, entry in enumerate(found)],
    }
    document = dict(finite(document))
    folder.write(folder.place / SUMMARY, folder.as_json(document))
    return document


def broken_harness(document: dict[str, Any]) -> bool:
    """Tell whether the plant broke one of its own rules in some run."""
    return any(HARNESS_FAULT in candidate["verdicts"] for candidate in document["candidates"])


def _candidate(
    plan: CampaignPlan, folder: CampaignFolder, place: int, found: CandidateStatistics
) -> dict[str, Any]:
    candidate = plan.candidates[place]
    files = _fault_files(plan, folder, found)
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
    check = _BY_ID[entry.check]
    return {
        "id": entry.check,
        "level": check.level,
        "subject": check.subject,
        **plain(entry.violated),
        "advisory_runs": entry.advised,
        "margin_quantiles": list(entry.quantiles),
        "worst_run": entry.worst_run,
        "worst_margin": entry.worst_margin,
        "counterexample": _counterexample(plan, folder, place, entry),
    }


def _counterexample(
    plan: CampaignPlan, folder: CampaignFolder, place: int, entry: CheckStatistics
) -> str | None:
    """Write the worst run of a check that it violates, and tell where."""
    if entry.worst_run is None or entry.worst_margin is None or entry.worst_margin >= 0.0:
        return None
    check, candidate = _BY_ID[entry.check], plan.candidates[place]
    scenario = plan.run(entry.worst_run).scenario.to_mapping()
    content = {
        "schema": Counterexample.schema_current,
        "kind": KIND,
        "check": check.id,
        "requirement": bounded_line(check.requirement),
        "limit": bounded_line(check.limit),
        "margin": finite(entry.worst_margin),
        "measured": bounded_line(_measured(plan, folder, entry)),
        "seed": plan.campaign.seed,
        "size": size_of(scenario),
        "candidate": {"name": bounded_line(candidate.name), "hash": candidate.content_hash},
        "versions": versions(),
        "scenario": scenario,
    }
    if content["margin"] is None:
        del content["margin"]
    document = parse_document(content, Counterexample, f"the counterexample to {check.id}")
    path = f"{COUNTEREXAMPLES}/{quote(candidate.name, safe='')}/{check.id}.json"
    folder.write(folder.place / path, document.to_json())
    return path


def _measured(plan: CampaignPlan, folder: CampaignFolder, entry: CheckStatistics) -> str:
    """Find what a margin was measured as; a row keeps that of its own worst check only."""
    number = entry.worst_run or 0
    chunk = next(chunk for chunk in plan.chunks() if chunk.first <= number < chunk.first + chunk.length)
    (table,) = columns_of([folder.path_of(chunk)], ("check", "measured"))
    row = table.slice(number - chunk.first, 1).to_pylist()[0]
    return str(row["measured"]) if row["check"] == entry.check else ""


def _fault_files(plan: CampaignPlan, folder: CampaignFolder, found: CandidateStatistics) -> dict[str, str]:
    """Write the scenario of the first run that each kind of fault ended."""
    files = {}
    for verdict, number in found.first_faults.items():
        files[verdict] = f"{FAULTS}/{quote(found.name, safe='')}/{verdict.replace(' ', '-')}.json"
        folder.write(folder.place / files[verdict], plan.run(number).scenario.to_json())
    return files
