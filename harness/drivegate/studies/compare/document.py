"""The document of a comparison on one drive: everything that its report is made from, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any, Final

from drivegate.candidates.fault import Fault, bounded_line
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import POINTS, Comparison, ComparisonRequest, PlannedRun, Row, RunTable
from drivegate.results.provenance import hash_of_content, provenance
from drivegate.results.result import finite
from drivegate.studies.compare.engine import CHECKS_EFFORT, COMPARED, Best, Compared
from drivegate.studies.compare.ranking import METHOD, difference_rows, ranking_rows, region_rows, rule_of
from drivegate_cases.drive.drive_document import DriveDocument

SCHEMA: Final = 1
"""Version of the comparison document, whatever the contract."""


def comparison_document(
    all_compared: Sequence[Compared],
    plan: Sequence[PlannedRun],
    best: Best,
    request: ComparisonRequest,
    *,
    checks: bool,
    timing: Mapping[str, Any],
) -> dict[str, Any]:
    """Put a comparison together."""
    drive = request.drive
    comparison = contract_of(drive).comparison()
    facts = comparison.facts(request, plan)
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": comparison.kind,
        "effort": request.effort,
        "seed": request.seed,
        "rule": rule_of(comparison.ranking, checks=checks),
        **({"method": METHOD} if comparison.populations else {}),
        "checks_effort": CHECKS_EFFORT if checks else None,
        **facts,
        "drive": {
            **drive.identity(),
            "base_speed_rpm": drive.rating.base_speed_rpm,
            "rated_power_w": drive.rating.rated_power_w,
            **facts["drive"],
        },
        "size": facts["size"] | {"runs_of_each": len(plan)},
        "candidates": [_candidate(compared) for compared in all_compared],
        "tables": _tables(all_compared, plan, best, drive, comparison),
        **{name: _curves(all_compared, plan, *where) for name, where in comparison.curves.items()},
    }
    return sealed(
        content,
        # What a dying process printed differs from run to run.
        lambda made: (
            made
            | {
                "candidates": [
                    {**entry, "faults": [{**fault, "traceback": ""} for fault in entry["faults"]]}
                    for entry in made["candidates"]
                ]
            }
        ),
        {
            **timing,
            "steps": [
                {"candidate": compared.label, **compared.timing}
                for compared in all_compared
                if compared.timing
            ],
        },
    )


def sealed(content: dict[str, Any], hashed: Any, timing: Mapping[str, Any]) -> dict[str, Any]:
    """Add provenance, with the hash of what `hashed` returns of the content, and the times, which are not hashed."""
    content = {key: finite(value) for key, value in (content | {"provenance": provenance()}).items()}
    content["provenance"] = content["provenance"] | {"content_hash": hash_of_content(hashed(content))}
    return content | {"timing": finite(dict(timing))}


def _tables(
    all_compared: Sequence[Compared],
    plan: Sequence[PlannedRun],
    best: Best,
    drive: DriveDocument,
    comparison: Comparison,
) -> dict[str, list[Row]]:
    """Make every table, the ones that decide first."""
    runs = {table.name: _run_rows(table, all_compared, plan, best) for table in comparison.tables}
    ranking = ranking_rows(all_compared, comparison.ranking, runs)
    tables = {"ranking": ranking}
    if comparison.region_ends_rpm is not None:
        labels = [compared.label for compared in all_compared if compared.status == COMPARED]
        ends = comparison.region_ends_rpm(drive)
        tables["regions"] = region_rows(labels, runs[POINTS], ends, comparison.ranking.costs)
    if comparison.populations:
        ranked = [row["candidate"] for row in ranking if row["status"] == COMPARED]
        tables["differences"] = difference_rows(ranked, comparison.populations, runs)
    return (
        tables | runs | comparison.best_tables(plan, best, runs[POINTS]) | {"checks": _checks(all_compared)}
    )


def _run_rows(
    table: RunTable, all_compared: Sequence[Compared], plan: Sequence[PlannedRun], best: Best
) -> list[Row]:
    """List what was measured in a table's runs, candidate by candidate."""
    return [
        {"candidate": compared.label, **row}
        for group in table.groups
        for compared in all_compared
        for index, planned in enumerate(plan)
        if planned.group == group and index in compared.figures
        for row in table.rows(planned, compared.figures[index], best.get(("point", index)))
    ]


def _checks(all_compared: Sequence[Compared]) -> list[Row]:
    """List verdict and margin of each check for each candidate."""
    keys = ("level", "verdict", "margin", "measured", "runs", "requirement")
    return [
        {
            "candidate": compared.label,
            "check": outcome.id,
            **{key: getattr(outcome, key) for key in keys},
        }
        for compared in all_compared
        for outcome in compared.outcomes or ()
        # What takes times is reported with the times.
        if outcome.id != "TIM-1" and outcome.subject == "candidate"
    ]


def _candidate(compared: Compared) -> dict[str, Any]:
    """Return what a candidate is and what has become of it."""
    candidate = compared.candidate
    return {
        "label": compared.label,
        "specification": compared.specification,
        "kind": None if candidate is None else candidate.kind,
        "hash": None if candidate is None else candidate.content_hash,
        "status": compared.status,
        "refusal": None if compared.error is None else bounded_line(str(compared.error)),
        "complete": compared.complete,
        "faults": [_fault(fault) for fault in compared.faults],
    }


def _fault(fault: Fault) -> dict[str, Any]:
    # A comparison states its scenarios once, for all candidates.
    document = asdict(replace(fault, scenario=None))
    del document["scenario"]
    document["kind"] = fault.kind.value
    document["time_s"] = document.pop("time")
    return document


def _curves(
    all_compared: Sequence[Compared], plan: Sequence[PlannedRun], group: str, key: str
) -> list[dict[str, Any]]:
    """Collect the curves of a group, without repetitions with other noise."""
    return [
        {"candidate": compared.label, "run": planned.label, **compared.figures[index][key]}
        for index, planned in enumerate(plan)
        if planned.group == group and planned.seed is None
        for compared in all_compared
        if index in compared.figures
    ]
