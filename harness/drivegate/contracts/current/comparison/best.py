"""What the drive can do at best at the operating points of a comparison, whatever the controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees, isfinite
from typing import Any

from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.comparison import PlannedRun, Row
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady import oracle
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM


def solved(_loaded: JudgedCandidate, planned: PlannedRun) -> Row:
    """Solve an operating point at two torques, between which every candidate's mean torque lies.

    They are without and with the most that core loss can take at the shaft. This is what a worker process does.
    """
    drive, speed = _plant_and_speed(planned)
    assert planned.share is not None, "an operating point has a load"
    load = planned.scenario.drive.rating.rated_power_w * planned.share / speed
    own = friction_torque(drive, speed)
    core = drive.phases * drive.core_loss_conductance * drive.emf_constant * drive.emf_constant * speed
    torques = [load + own, load + own + core]
    edges = [oracle.feasible_edge(drive, speed, torque) for torque in torques]
    sums = [oracle.least_current_sum(drive, speed, torque).current_sum for torque in torques]
    powers = [oracle.least_input_power(drive, speed, torque).input_power for torque in torques]
    reachable = all(map(isfinite, (*edges, *sums, *powers)))
    return {
        "feasible": reachable,
        "torques_nm": torques,
        "edges_deg": [*map(degrees, edges)] if reachable else None,
        "least_current_sums_a": sums if reachable else None,
        "least_input_powers_w": powers if reachable else None,
    }


def _plant_and_speed(planned: PlannedRun) -> tuple[AnyDrive, float]:
    """Return plant and speed of an operating point (rad/s)."""
    assert planned.speed_rpm is not None, "an operating point has a speed"
    return planned.scenario.drive.plant(), planned.speed_rpm * RADIANS_PER_RPM


def least_at(best: Row, key: str, torque_nm: float) -> float | None:
    """Interpolate an optimum at a torque between the two that were solved."""
    values = best[key]
    if values is None:
        return None
    low, high = best["torques_nm"]
    share = (torque_nm - low) / (high - low) if high > low else 0.0
    return float(values[0] + share * (values[1] - values[0]))


def greatest_torque(_loaded: JudgedCandidate, planned: PlannedRun) -> float:
    """Find the greatest torque that some advance angle gives at a speed; this is what a worker process does."""
    return oracle.greatest_torque_at_limit(*_plant_and_speed(planned)).torque


def best_jobs(plan: Sequence[PlannedRun]) -> dict[tuple[str, float], Job[Any]]:
    """List the jobs that solve every operating point, and the greatest torque at each of their speeds."""
    points = {index: run for index, run in enumerate(plan) if run.group == "points"}
    by_speed = {run.speed_rpm: run for run in points.values() if run.speed_rpm is not None}
    return {
        **{("point", index): Job(solved, run) for index, run in points.items()},
        **{("envelope", speed): Job(greatest_torque, run) for speed, run in by_speed.items()},
    }


def best_tables(
    plan: Sequence[PlannedRun], found: Mapping[tuple[str, float], Any], points: Sequence[Row]
) -> dict[str, list[Row]]:
    """List the optima of the operating points at the mean torque of who holds them, and the greatest torques."""
    torques: dict[tuple[float, float], list[float]] = {}
    for row in points:
        if row["held"]:
            torques.setdefault((row["speed_rpm"], row["load_percent"]), []).append(row["torque_mean_nm"])
    rows = []
    for index, planned in enumerate(plan):
        if planned.group == "points":
            where, best = where_of(planned), found["point", index]
            held = torques.get((where["speed_rpm"], where["load_percent"]))
            torque = sum(held) / len(held) if held else float(best["torques_nm"][0])
            rows.append(
                where
                | {
                    "feasible": best["feasible"],
                    "edge_deg": least_at(best, "edges_deg", torque),
                    "electromagnetic_torque_nm": torque,
                    "least_current_sum_a": least_at(best, "least_current_sums_a", torque),
                    "least_input_power_w": least_at(best, "least_input_powers_w", torque),
                }
            )
    envelope = [
        {"speed_rpm": speed, "torque_nm": torque}
        for (what, speed), torque in found.items()
        if what == "envelope"
    ]
    return {"best_possible": rows, "envelope": envelope}


def where_of(planned: PlannedRun) -> Row:
    """Return speed and load of an operating point."""
    assert planned.speed_rpm is not None, "an operating point has a speed"
    assert planned.share is not None, "an operating point has a load"
    power = planned.scenario.drive.rating.rated_power_w * planned.share
    return {
        "speed_rpm": planned.speed_rpm,
        "load_percent": round(100.0 * planned.share, 6),
        "torque_nm": round(power / (planned.speed_rpm * RADIANS_PER_RPM), 6),
    }
