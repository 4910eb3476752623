"""The rows of a comparison: what a candidate came to in one run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from drivegate.contracts.comparison import ComparisonRequest, DrivePoint, PlannedRun, Row
from drivegate.contracts.current.comparison.best import least_at, where_of
from drivegate.contracts.current.comparison.plan import EFFORTS, operating_speed
from drivegate_cases.scenario.load import ConstantTorqueLoad

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


def point_rows(planned: PlannedRun, figures: Row, best: Row | None) -> Iterator[Row]:
    """Return what a candidate came to at an operating point, next to the best possible."""
    assert best is not None, "every operating point is solved"
    yield {
        **where_of(planned),
        "feasible": best["feasible"],
        **{key: figures[key] for key in _STEADY},
        "converged_after_s": figures["converged_after_s"],
        **_gaps(figures, best),
    }


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


def disturbance_rows(planned: PlannedRun, figures: Row, _best: Row | None) -> Iterator[Row]:
    """Return how a candidate recovered from a disturbance."""
    yield {
        "disturbance": planned.label,
        **{key: figures[key] for key in ("held_before", "worst_error_rpm", "recovery_s")},
        "held_at_the_end": figures["held"],
        "input_power_w": figures["input_power_w"],
        "current_sum_a": figures["current_sum_a"],
    }


def repeated_rows(planned: PlannedRun, figures: Row, _best: Row | None) -> Iterator[Row]:
    """Return a run with noisy sensors, or one on a drawn plant."""
    yield {
        "group": planned.group,
        "scenario": planned.label,
        "seed": planned.seed,
        **where_of(planned),
        **{key: figures[key] for key in _STEADY},
        "converged_after_s": figures["converged_after_s"],
    }


def cycle_rows(planned: PlannedRun, figures: Row, _best: Row | None) -> Iterator[Row]:
    """Return what a candidate spent on the drive cycle."""
    yield {
        "sensors": planned.label,
        "seed": planned.seed,
        "follows": figures["outside_tolerance_s"] == 0.0,
        **{key: value for key, value in figures.items() if key not in ("samples", "energy_wh_by_phase")},
        **{f"energy_{phase}_wh": value for phase, value in figures["energy_wh_by_phase"].items()},
    }


def drive_points(
    request: ComparisonRequest, plan: Sequence[PlannedRun], all_figures: Mapping[int, Row]
) -> Iterator[DrivePoint]:
    """Return a candidate's points on a drive; two shares of a narrow range may be one speed."""
    points = [(index, planned) for index, planned in enumerate(plan) if planned.group == "points"]
    for share in EFFORTS[request.effort].speeds:
        speed = operating_speed(request.drive, share)
        for index, planned in points:
            if planned.speed_rpm != speed or index not in all_figures:
                continue
            load, figures = planned.scenario.load, all_figures[index]
            assert isinstance(load, ConstantTorqueLoad), "the load of an operating point is a torque"
            yield DrivePoint(
                speed_share=share,
                load_percent=where_of(planned)["load_percent"],
                speed_rpm=speed,
                torque_nm=load.torque_nm,
                **{key: figures[key] for key in _DRIVE_FIGURES},
            )


_DRIVE_FIGURES: Final = (
    "held",
    "speed_mean_rpm",
    "torque_mean_nm",
    "input_power_w",
    "current_sum_a",
    "ripple_percent",
)
"""Figures of a run by which drives are compared."""
