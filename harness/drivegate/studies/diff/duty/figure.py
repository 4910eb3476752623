"""What is drawn of the first difference between two candidates that answer with duty ratios."""

from __future__ import annotations

from drivegate.contracts.duty.run import DUTY_RATIOS
from drivegate.studies.diff.duty.comparison import DutyDifference
from drivegate.studies.diff.figure import DrawnSteps
from drivegate_models.units import RPM


def drawn_duty_steps(found: DutyDifference) -> DrawnSteps:
    """Take the three duty ratios of both, and the speed of the shaft."""
    rows = slice(found.begin, found.end)
    run = found.driven.run
    panels = tuple(
        (
            f"{name.replace('_', ' ')} ratio (1)",
            run.commands[name][rows].copy(),
            found.answers[name][rows].copy(),
        )
        for name in DUTY_RATIOS
    )
    return DrawnSteps(
        found.step,
        found.begin,
        float(found.driven.senses["time"][found.step]),
        panels,
        run.column("speed")[rows] * RPM,
    )
