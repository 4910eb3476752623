"""What the drive can do at best at the operating points of a comparison, whatever the controller."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, isfinite
from typing import Any

from drivegate.containment.messages import JudgedCandidate
from drivegate.drives.kinds import kind_of
from drivegate.studies.compare.plan import PlannedRun
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.units import RADIANS_PER_RPM


@dataclass(frozen=True)
class OraclePoint:
    """An operating point to be solved."""

    drive: DriveDocument
    """The drive."""
    speed_rpm: float
    """Speed (rpm)."""
    torques_nm: tuple[float, float]
    """Two torques, without and with the most that core loss can take at the shaft, between which every
    candidate's mean torque lies (N·m)."""


def oracle_point(planned: PlannedRun) -> OraclePoint:
    """Give the operating point of a planned run."""
    assert planned.speed_rpm is not None, "an operating point has a speed"
    assert planned.share is not None, "an operating point has a load"
    drive = planned.scenario.drive
    plant = drive.plant()
    speed = planned.speed_rpm * RADIANS_PER_RPM
    load = drive.rating.rated_power_w * planned.share / speed
    own = plant.friction + plant.viscous_friction * speed
    core = plant.phases * plant.core_loss_conductance * plant.emf_constant**2 * speed
    return OraclePoint(drive, planned.speed_rpm, (load + own, load + own + core))


def solved(_loaded: JudgedCandidate, point: OraclePoint) -> dict[str, Any]:
    """Solve an operating point; this is what a worker process does."""
    oracle, drive = kind_of(point.drive).oracle(), point.drive.plant()
    speed = point.speed_rpm * RADIANS_PER_RPM
    edges = [oracle.feasible_edge(drive, speed, torque) for torque in point.torques_nm]
    sums = [oracle.least_current_sum(drive, speed, torque).current_sum for torque in point.torques_nm]
    powers = [oracle.least_input_power(drive, speed, torque).input_power for torque in point.torques_nm]
    reachable = all(map(isfinite, (*edges, *sums, *powers)))
    return {
        "feasible": reachable,
        "torques_nm": list(point.torques_nm),
        "edges_deg": [*map(degrees, edges)] if reachable else None,
        "least_current_sums_a": sums if reachable else None,
        "least_input_powers_w": powers if reachable else None,
    }


def least_at(oracle: dict[str, Any], key: str, torque_nm: float) -> float | None:
    """Interpolate an optimum at a torque between the two that were solved."""
    values = oracle[key]
    if values is None:
        return None
    low, high = oracle["torques_nm"]
    share = (torque_nm - low) / (high - low) if high > low else 0.0
    return float(values[0] + share * (values[1] - values[0]))


def greatest_torque(_loaded: JudgedCandidate, point: OraclePoint) -> float:
    """Find the greatest torque that some advance angle gives at a speed; this is what a worker process does."""
    oracle, drive = kind_of(point.drive).oracle(), point.drive.plant()
    return oracle.greatest_torque_at_limit(drive, point.speed_rpm * RADIANS_PER_RPM).torque
