"""The summary of a campaign as plain data, with its worst runs as files that can be run again."""

from __future__ import annotations

from typing import Any, Final
from urllib.parse import quote

from drivegate.candidates.fault import bounded_line
from drivegate.contracts.catalogue import check_of, on_drive
from drivegate.results.counterexample import KIND as COUNTEREXAMPLE
from drivegate.results.counterexample import Counterexample
from drivegate.results.provenance import versions
from drivegate.results.result import finite
from drivegate.scenarios.simplification import size_of
from drivegate.studies.campaign.folder import CampaignFolder, columns_of
from drivegate.studies.campaign.plan import CampaignPlan
from drivegate.studies.campaign.row import HARNESS_FAULT, SET_ASIDE
from drivegate.studies.campaign.statistics import (
    QUANTILES,
    CandidateStatistics,
    CheckStatistics,
    plain,
    statistics,
)
from drivegate_cases.documents.document import parse_document

COUNTEREXAMPLES: Final = "counterexamples"
FAULTS: Final = "faults"
WORST: Final = "worst"
SCHEMA: Final = 2
SUMMARY: Final = "summary.json"
KIND: Final = "campaign summary"


def worst_case(
    plan: CampaignPlan, folder: CampaignFolder, place: int, entry: CheckStatistics
) -> dict[str, Any]:
    """Return the run of a candidate with the least margin of a check, and write what runs it again.

    That is a counterexample where the check is violated, and the run's scenario elsewhere.
    """
    if entry.worst_run is None or entry.worst_margin is None:
        names = ("counterexample", "worst_scenario", "worst_case", "worst_parameters", "worst_measured")
        return dict.fromkeys(names)
    run = plan.run(entry.worst_run)
    measured = _measured(plan, folder, entry.worst_run, entry.check)
    counterexample = scenario = None
    if entry.worst_margin < 0.0:
        counterexample = _counterexample(plan, folder, place, entry, measured)
    else:
        scenario = f"{WORST}/run-{entry.worst_run:06d}.json"
        folder.write(folder.place / scenario, run.scenario.to_json())
    return {
        "counterexample": counterexample,
        "worst_scenario": scenario,
        "worst_case": run.case,
        "worst_parameters": run.parameters,
        "worst_measured": measured,
    }


def _counterexample(
    plan: CampaignPlan, folder: CampaignFolder, place: int, entry: CheckStatistics, measured: str
) -> str:
    """Write the worst run of a check that it violates, and return where."""
    worst, candidate = plan.run(entry.worst_run or 0).scenario, plan.candidates[place]
    drive, scenario = worst.drive, worst.to_mapping()
    check = on_drive(check_of(drive.contract, entry.check), drive, candidate.declaration)
    content = {
        "schema": Counterexample.schema_current,
        "kind": COUNTEREXAMPLE,
        "check": check.id,
        "requirement": bounded_line(check.requirement),
        "limit": bounded_line(check.limit),
        "margin": finite(entry.worst_margin),
        "measured": bounded_line(measured),
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


def _measured(plan: CampaignPlan, folder: CampaignFolder, number: int, check: str) -> str:
    """Find what a margin was measured as; a row keeps that of its own worst check only."""
    chunk = next(chunk for chunk in plan.chunks() if chunk.first <= number < chunk.first + chunk.length)
    (table,) = columns_of([folder.path_of(chunk)], ("check", "measured"))
    row = table.slice(number - chunk.first, 1).to_pylist()[0]
    return str(row["measured"]) if row["check"] == check else ""


def fault_files(plan: CampaignPlan, folder: CampaignFolder, found: CandidateStatistics) -> dict[str, str]:
    """Write the scenario of the first run that each kind of fault ended."""
    files = {}
    for verdict, number in found.first_faults.items():
        files[verdict] = f"{FAULTS}/{quote(found.name, safe='')}/{verdict.replace(' ', '-')}.json"
        folder.write(folder.place / files[verdict], plan.run(number).scenario.to_json())
    return files


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
        "not_passed": plain(found.violated, plan),
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
        **plain(entry.violated, plan),
        "advisory_runs": entry.advised,
        "margin_quantiles": list(entry.quantiles),
        "margins": list(entry.curve),
        "worst_run": entry.worst_run,
        "worst_margin": entry.worst_margin,
        **worst_case(plan, folder, place, entry),
    }
