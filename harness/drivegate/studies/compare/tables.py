"""The tables of a comparison: flat rows of what each candidate came to in each run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.oracle import least_at
from drivegate.studies.compare.plan import PlannedRun
from drivegate_models.units import RADIANS_PER_RPM

Row = dict[str, Any]

_STEADY: Final = (
    "held",
    "speed_error_rpm",
    "torque_mean_nm",
    "input_power_w",
    "current_sum_a",
    "ripple_percent",
    "advance_deg",
    "current_peak_a",
)


def oracle_rows(
    all_compared: Sequence[Compared], plan: Sequence[PlannedRun], oracle: dict[str, Any]
) -> list[Row]:
    """List the optima of the operating points."""
    points = [planned for planned in plan if planned.group == "points"]
    torques: dict[int, list[float]] = {}
    for _, position, _, figures in _runs(all_compared, plan, "points"):
        if figures["held"]:
            torques.setdefault(position, []).append(figures["torque_mean_nm"])
    return [
        {
            **_where(planned),
            "feasible": best["feasible"],
            "edge_deg": least_at(best, "edges_deg", torque),
            "electromagnetic_torque_nm": torque,
            "least_current_sum_a": least_at(best, "least_current_sums_a", torque),
            "least_input_power_w": least_at(best, "least_input_powers_w", torque),
        }
        for position, (planned, best) in enumerate(zip(points, oracle["points"], strict=True))
        for torque in [_mean_torque(torques.get(position), best)]
    ]


def _mean_torque(torques: Sequence[float] | None, best: dict[str, Any]) -> float:
    return sum(torques) / len(torques) if torques else float(best["torques_nm"][0])


def point_rows(
    all_compared: Sequence[Compared], plan: Sequence[PlannedRun], oracle: dict[str, Any]
) -> list[Row]:
    """List what each candidate came to at each operating point, beside the best possible."""
    return [
        {
            "candidate": compared.label,
            **_where(planned),
            "feasible": oracle["points"][position]["feasible"],
            **{key: figures[key] for key in _STEADY},
            "converged_after_s": figures["converged_after_s"],
            **_gaps(figures, oracle["points"][position]),
        }
        for compared, position, planned, figures in _runs(all_compared, plan, "points")
    ]


def _gaps(figures: Row, best: Row) -> Row:
    """Compare a steady run with the best angle for the same torque; nothing where it was not held."""
    gaps: Row = dict.fromkeys(("gap_power_w", "gap_power_percent", "gap_current_percent", "above_edge_deg"))
    if not (figures["held"] and best["feasible"]):
        return gaps
    torque = figures["torque_mean_nm"]
    power, current, edge = (
        least_at(best, key, torque) for key in ("least_input_powers_w", "least_current_sums_a", "edges_deg")
    )
    if power is not None and power > 0.0:
        gaps["gap_power_w"] = figures["input_power_w"] - power
        gaps["gap_power_percent"] = 100.0 * (figures["input_power_w"] / power - 1.0)
    if current is not None and current > 0.0:
        gaps["gap_current_percent"] = 100.0 * (figures["current_sum_a"] / current - 1.0)
    if edge is not None:
        gaps["above_edge_deg"] = figures["advance_deg"] - edge
    return gaps


def disturbance_rows(all_compared: Sequence[Compared], plan: Sequence[PlannedRun]) -> list[Row]:
    """List how each candidate got over each disturbance."""
    return [
        {
            "candidate": compared.label,
            "disturbance": planned.label,
            "held_before": figures["held_before"],
            "worst_error_rpm": figures["worst_error_rpm"],
            "recovery_s": figures["recovery_s"],
            "held_at_the_end": figures["held"],
            "input_power_w": figures["input_power_w"],
            "current_sum_a": figures["current_sum_a"],
        }
        for compared, _, planned, figures in _runs(all_compared, plan, "disturbances")
    ]


def repeated_rows(all_compared: Sequence[Compared], plan: Sequence[PlannedRun]) -> list[Row]:
    """List the runs with noisy sensors and those on drawn plants."""
    return [
        {
            "candidate": compared.label,
            "group": group,
            "scenario": planned.label,
            "seed": planned.seed,
            **_where(planned),
            **{key: figures[key] for key in _STEADY},
            "converged_after_s": figures["converged_after_s"],
        }
        for group in ("noise", "drawn")
        for compared, _, planned, figures in _runs(all_compared, plan, group)
    ]


def cycle_rows(all_compared: Sequence[Compared], plan: Sequence[PlannedRun]) -> list[Row]:
    """List what each candidate spent on the drive cycle."""
    return [
        {
            "candidate": compared.label,
            "sensors": planned.label,
            "seed": planned.seed,
            "follows": figures["outside_tolerance_s"] == 0.0,
            **{key: value for key, value in figures.items() if key not in ("samples", "energy_wh_by_phase")},
            **{f"energy_{phase}_wh": value for phase, value in figures["energy_wh_by_phase"].items()},
        }
        for compared, _, planned, figures in _runs(all_compared, plan, "cycle")
    ]


def check_rows(all_compared: Sequence[Compared]) -> list[Row]:
    """List verdict and margin of each check for each candidate."""
    return [
        {
            "candidate": compared.label,
            "check": outcome.id,
            "level": outcome.level,
            "verdict": outcome.verdict,
            "margin": outcome.margin,
            "measured": outcome.measured,
            "runs": outcome.runs,
            "requirement": outcome.requirement,
        }
        for compared in all_compared
        for outcome in compared.outcomes or ()
        # What takes times is reported with the times.
        if outcome.id != "TIM-1" and outcome.subject == "candidate"
    ]


def _runs(
    all_compared: Sequence[Compared], plan: Sequence[PlannedRun], group: str
) -> Iterator[tuple[Compared, int, PlannedRun, Row]]:
    """Go through the runs of a group that were made: candidate, position within the group, run, figures."""
    inside = [index for index, planned in enumerate(plan) if planned.group == group]
    for compared in all_compared:
        for position, index in enumerate(inside):
            if index in compared.figures:
                yield compared, position, plan[index], compared.figures[index]


def _where(planned: PlannedRun) -> Row:
    assert planned.speed_rpm is not None, "an operating point has a speed"
    assert planned.share is not None, "an operating point has a load"
    power = planned.scenario.drive.rating.rated_power_w * planned.share
    return {
        "speed_rpm": planned.speed_rpm,
        "load_percent": round(100.0 * planned.share, 6),
        "torque_nm": round(power / (planned.speed_rpm * RADIANS_PER_RPM), 6),
    }
