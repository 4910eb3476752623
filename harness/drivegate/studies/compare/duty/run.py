"""One run of such a comparison: what is measured of a candidate."""

from __future__ import annotations

from typing import Any

from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.points import steady_points, step_rows
from drivegate.drives.running import recorded
from drivegate.studies.compare.duty.plan import DutyPlannedRun


def measured_duty(loaded: JudgedCandidate, planned: DutyPlannedRun) -> dict[str, Any]:
    """Run a candidate through a planned run."""
    record = duty_record(recorded(loaded, planned.scenario, loaded.controller()))
    rows = steady_points(record) if planned.group == "points" else list(step_rows(record))
    return {planned.group: rows}
