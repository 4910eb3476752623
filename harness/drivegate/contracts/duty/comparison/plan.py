"""What every controller of duty ratios of a comparison runs: torques at constant speeds, with steps, or loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from drivegate.contracts.comparison import ComparisonRequest, PlannedRun
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import speed_scenario, torque_of, torque_scenario
from drivegate.contracts.duty.scenarios.fixed import speed_of
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import on_whole_periods

SEARCH_S: Final = 6.0
"""Length of a run of a speed reference, in which a search of seconds finds its angle (s)."""
STEPS: Final = (0.0, 0.5, 0.2, 0.8, 0.4)
"""Torques of a run with steps, over the torque of rated power (1)."""


@dataclass(frozen=True)
class DutyEffort:
    """How much is run."""

    speeds: tuple[float, ...]
    """Speeds of the operating points: 0 is base speed, 1 the highest, -1 standstill."""
    torques: tuple[float, ...]
    """Their torques, over the torque of rated power at that speed (1)."""
    step_speeds: tuple[float, ...]
    """Speeds at which the torque reference steps, likewise."""


EFFORTS: Final = {
    "quick": DutyEffort((-0.9, -0.5, 0.0, 0.5, 1.0), (0.25, 0.5, 0.9), (-0.8, -0.4)),
    "default": DutyEffort(
        (-0.95, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0),
        (0.1, 0.25, 0.5, 0.75, 0.9),
        (-1.0, -0.8, -0.6, -0.4),
    ),
    "nightly": DutyEffort(
        (*(-0.95 + 0.15 * step for step in range(6)), *(0.1 * step for step in range(11))),
        (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9),
        tuple(-1.0 + 0.1 * step for step in range(9)),
    ),
}
"""What is run, by the name of the effort."""


def planned_duty_runs(request: ComparisonRequest) -> tuple[PlannedRun, ...]:
    """Plan the runs of a comparison; those of a speed reference have the same speeds and loads, and no steps."""
    runs = _loads if request.reference == "speed" else _torques
    return tuple(runs(duty_document(request.drive), EFFORTS[request.effort]))


def _loads(drive: PmAcDocument, size: DutyEffort) -> Iterator[PlannedRun]:
    for speed in dict.fromkeys(speed_of(drive, share) for share in size.speeds):
        for share in size.torques:
            torque = torque_of(drive, speed, share)
            run = speed_scenario(drive, (speed,), torque_nm=torque)
            searched = on_whole_periods(SEARCH_S, drive.control_period_s)
            whole = titled(run.replaced(duration_s=max(run.duration_s, searched)))
            yield PlannedRun("points", f"{torque:g} N·m at {speed:g} rpm", whole)


def _torques(drive: PmAcDocument, size: DutyEffort) -> Iterator[PlannedRun]:
    for speed in dict.fromkeys(speed_of(drive, share) for share in size.speeds):
        torques = [torque_of(drive, speed, share) for share in size.torques]
        yield PlannedRun("points", f"torques at {speed:g} rpm", torque_scenario(drive, speed, torques))
    for speed in dict.fromkeys(speed_of(drive, share) for share in size.step_speeds):
        torques = [torque_of(drive, speed, share) for share in STEPS]
        yield PlannedRun("steps", f"steps at {speed:g} rpm", torque_scenario(drive, speed, torques))
