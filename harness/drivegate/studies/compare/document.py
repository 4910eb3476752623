"""The document of a comparison: everything that its report is made from, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final

from drivegate.candidates.fault import Fault, bounded_line
from drivegate.contracts.current.numbers import sensors_of
from drivegate.results.provenance import hash_of_content, provenance
from drivegate.results.result import finite
from drivegate.scenarios.drive_scale import scale_of
from drivegate.studies.compare.differences import difference_rows
from drivegate.studies.compare.drive_cycle_run import TOLERANCE_KM_H, cycle_vehicle
from drivegate.studies.compare.engine import CHECKS_EFFORT, Compared
from drivegate.studies.compare.plan import EFFORTS, PlannedRun
from drivegate.studies.compare.ranking import (
    COMPARED,
    RULE,
    RULE_WITHOUT_CHECKS,
    ranking_rows,
    region_rows,
    status_of,
)
from drivegate.studies.compare.statistics import METHOD
from drivegate.studies.compare.tables import (
    check_rows,
    cycle_rows,
    disturbance_rows,
    oracle_rows,
    point_rows,
    repeated_rows,
)
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.drive_cycle import DriveCycle

SCHEMA: Final = 1
"""Version of the comparison document."""
KIND: Final = "comparison"
"""Kind of the document."""


def comparison_document(
    all_compared: Sequence[Compared],
    plan: Sequence[PlannedRun],
    oracle: dict[str, Any],
    *,
    drive: DriveDocument,
    cycle: DriveCycle,
    effort: str,
    seed: int,
    checks: bool,
    timing: Mapping[str, Any],
) -> dict[str, Any]:
    """Put a comparison together."""
    points = point_rows(all_compared, plan, oracle)
    ranking = ranking_rows(all_compared, points)
    repeated, cycles = repeated_rows(all_compared, plan), cycle_rows(all_compared, plan)
    ranked = [row["candidate"] for row in ranking if row["status"] == COMPARED]
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": KIND,
        "effort": effort,
        "seed": seed,
        "rule": RULE if checks else RULE_WITHOUT_CHECKS,
        "method": METHOD,
        "checks_effort": CHECKS_EFFORT if checks else None,
        "drive": {
            **drive.identity(),
            "base_speed_rpm": drive.rating.base_speed_rpm,
            "rated_power_w": drive.rating.rated_power_w,
            "speed_tolerance_rpm": limits_of(drive).speed_tolerance_rpm,
            "change_s": scale_of(drive).change_s,
            "sensors": sensors_of(drive),
        },
        "size": _size(effort, plan),
        "cycle": _cycle(cycle, drive),
        "candidates": [candidate_entry(compared) for compared in all_compared],
        "tables": {
            "ranking": ranking,
            "regions": region_rows(all_compared, points, scale_of(drive)),
            "differences": difference_rows(ranked, repeated, cycles),
            "operating_points": points,
            "best_possible": oracle_rows(all_compared, plan, oracle),
            "envelope": oracle["envelope"],
            "disturbances": disturbance_rows(all_compared, plan),
            "repetitions": repeated,
            "drive_cycle": cycles,
            "checks": check_rows(all_compared),
        },
        "trajectories": _kept(all_compared, plan, "disturbances", "trajectory"),
        "cycle_samples": _kept(all_compared, plan, "cycle", "samples"),
        "provenance": provenance(),
    }
    content = {key: finite(value) for key, value in content.items()}
    content["provenance"] = {
        **content["provenance"],
        "content_hash": hash_of_content(hashed_content(content)),
    }
    content["timing"] = finite(
        {
            **timing,
            "steps": [
                {"candidate": compared.label, **compared.timing}
                for compared in all_compared
                if compared.timing
            ],
        }
    )
    return content


def hashed_content(content: dict[str, Any]) -> dict[str, Any]:
    """Leave out what a dying process printed, which differs from run to run."""
    candidates = [
        {**entry, "faults": [{**fault, "traceback": ""} for fault in entry["faults"]]}
        for entry in content["candidates"]
    ]
    return {**content, "candidates": candidates}


def candidate_entry(compared: Compared) -> dict[str, Any]:
    """Tell what a candidate is and what has become of it."""
    candidate = compared.candidate
    return {
        "label": compared.label,
        "specification": compared.specification,
        "kind": None if candidate is None else candidate.kind,
        "hash": None if candidate is None else candidate.content_hash,
        "status": status_of(compared),
        "refusal": None if compared.error is None else bounded_line(str(compared.error)),
        "complete": compared.complete,
        "faults": [_fault(fault) for fault in compared.faults],
    }


def _fault(fault: Fault) -> dict[str, Any]:
    document = asdict(fault)
    document["kind"] = fault.kind.value
    document["time_s"] = document.pop("time")
    return document


def _size(effort: str, plan: Sequence[PlannedRun]) -> dict[str, Any]:
    """Tell how much is run, with the speeds that the shares of the effort are on this drive."""
    size = asdict(EFFORTS[effort])
    del size["speeds"]
    speeds = dict.fromkeys(run.speed_rpm for run in plan if run.group == "points")
    return {"speeds_rpm": list(speeds)} | size | {"runs_of_each": len(plan)}


def _cycle(cycle: DriveCycle, drive: DriveDocument) -> dict[str, Any]:
    return {
        "name": cycle.name,
        "description": cycle.description,
        "source": cycle.source,
        "duration_s": cycle.duration_s,
        "distance_km": cycle.distance_m / 1000.0,
        "tolerance_km_h": TOLERANCE_KM_H,
        "vehicle": cycle_vehicle(drive).model_dump(mode="json", exclude={"kind", "grade_percent"}),
    }


def _kept(
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
