"""The document of a comparison of controllers of duty ratios: everything that its report is made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from drivegate.results.provenance import hash_of_content, provenance
from drivegate.results.result import finite
from drivegate.studies.compare.document import candidate_entry, hashed_content
from drivegate.studies.compare.duty.plan import EFFORTS, DutyPlannedRun
from drivegate.studies.compare.duty.ranking import RULE, RULE_WITHOUT_CHECKS, duty_ranking
from drivegate.studies.compare.engine import CHECKS_EFFORT, Compared
from drivegate.studies.compare.tables import check_rows
from drivegate_cases.documents.rounding import significant
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import duty_limits_of
from drivegate_cases.scenario.reference import Reference

SCHEMA: Final = 1
"""Version of the document."""
DUTY_KIND: Final = "duty-comparison"
"""Kind of the document."""
_DIGITS: Final = 6


def duty_document(
    all_compared: Sequence[Compared],
    plan: Sequence[DutyPlannedRun],
    *,
    drive: PmAcDocument,
    reference: Reference = "torque",
    effort: str,
    seed: int,
    checks: bool,
    timing: Mapping[str, Any],
) -> dict[str, Any]:
    """Put a comparison together."""
    points, steps = (_rows(all_compared, plan, group) for group in ("points", "steps"))
    limits = duty_limits_of(drive)
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": DUTY_KIND,
        "effort": effort,
        "seed": seed,
        "reference": reference,
        "rule": RULE if checks else RULE_WITHOUT_CHECKS,
        "checks_effort": CHECKS_EFFORT if checks else None,
        "drive": {
            **drive.identity(),
            "base_speed_rpm": drive.rating.base_speed_rpm,
            "rated_power_w": drive.rating.rated_power_w,
            "rated_torque_nm": limits.rated_torque_nm,
            "torque_tolerance_nm": limits.torque_error_nm,
            "speed_tolerance_rpm": limits.speed_tolerance_rpm,
            "overshoot_limit_percent": 100.0 * limits.overshoot,
        },
        "size": {"torques": list(EFFORTS[effort].torques), "runs_of_each": len(plan)},
        "candidates": [candidate_entry(compared) for compared in all_compared],
        "tables": {
            "ranking": duty_ranking(all_compared, points, steps),
            "operating_points": points,
            "steps": steps,
            "checks": check_rows(all_compared),
        },
        "provenance": provenance(),
    }
    content = {key: finite(value) for key, value in content.items()}
    content["provenance"] = {
        **content["provenance"],
        "content_hash": hash_of_content(hashed_content(content)),
    }
    content["timing"] = finite(dict(timing))
    return content


def _rows(
    all_compared: Sequence[Compared], plan: Sequence[DutyPlannedRun], group: str
) -> list[dict[str, Any]]:
    """List what was measured in a group of runs, candidate by candidate."""
    return [
        {"candidate": compared.label, **{key: _rounded(value) for key, value in row.items()}}
        for compared in all_compared
        for index, planned in enumerate(plan)
        if planned.group == group and index in compared.figures
        for row in compared.figures[index][group]
    ]


def _rounded(value: Any) -> Any:
    # Smaller than that is what rounding leaves of none.
    return significant(round(value, _DIGITS), _DIGITS) + 0.0 if isinstance(value, float) else value
