"""One run of a comparison: what is measured of a candidate, and the rows that it adds to the tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import degrees
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Record
from drivegate.contracts.comparison import ComparisonRequest, PlannedRun, Row
from drivegate.contracts.current.comparison.best import least_at, where_of
from drivegate.contracts.current.comparison.drive_cycle import cycle_figures
from drivegate.contracts.current.comparison.plan import EFFORTS, operating_speed
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.limits import Limits, limits_of
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_models.loop import observation
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.units import RADIANS_PER_RPM

TRACE_EVERY: Final = 20
"""Control periods from one kept row of a trace to the next: 10 ms."""
SHOWN_EVERY_S: Final = 0.05
"""Time between two rows of a trajectory that the report draws (s)."""
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


def trace_every(planned: PlannedRun) -> int:
    """Return the control periods from one kept row of a trace to the next."""
    return 1 if planned.group == "cycle" else TRACE_EVERY


def measured(planned: PlannedRun, record: Record) -> Row:
    """Return the figures of a run."""
    run: Any = record.run
    if planned.group == "cycle":
        return cycle_figures(planned.scenario, run)
    limits = limits_of(planned.scenario.drive)
    figures = steady_figures(run, limits)
    columns = _columns(run)
    if planned.group == "disturbances" and planned.change_s is not None:
        begins = scale_of(planned.scenario.drive).change_s
        return (
            figures
            | recovery_figures(columns, begins, planned.change_s, limits)
            | {"trajectory": _trajectory(columns)}
        )
    return figures | {"converged_after_s": converged_after(columns, figures, limits)}


def steady_figures(run: ClosedLoopRun, limits: Limits) -> Row:
    """Return what the last steady stretch of a run came to; it is held within k1."""
    row = run.windows[-1]
    error = row.speed_error / RADIANS_PER_RPM
    return {
        "held": error <= limits.speed_tolerance_rpm,
        "speed_error_rpm": error,
        "speed_mean_rpm": row.speed / RADIANS_PER_RPM,
        "torque_mean_nm": row.torque,
        "input_power_w": row.input_power,
        "current_sum_a": row.current_sum,
        "ripple_percent": 100.0 * row.ripple,
        "advance_deg": degrees(row.angle),
        "current_peak_a": row.peak,
    }


def converged_after(columns: dict[str, NDArray[np.float64]], figures: Row, limits: Limits) -> float | None:
    """Return when a run had converged: from then on the speed is held and the angle stays near its last mean."""
    error = np.abs(columns["speed_rpm"] - columns["speed_reference_rpm"])
    moved = np.abs(columns["advance_deg"] - figures["advance_deg"])
    return _settled(
        columns["time_s"], (error > limits.speed_tolerance_rpm) | (moved > limits.angle_tolerance_deg)
    )


def recovery_figures(
    columns: dict[str, NDArray[np.float64]], begins_s: float, change_s: float, limits: Limits
) -> Row:
    """Return how a candidate got over a disturbance, from when it begins and when it is over."""
    times = columns["time_s"]
    error = np.abs(columns["speed_rpm"] - columns["speed_reference_rpm"])
    after = times >= change_s
    since = times >= change_s - 1.0
    before = (times >= begins_s - 1.0) & (times < begins_s)
    recovered = _settled(times[after], error[after] > limits.speed_tolerance_rpm)
    return {
        "held_before": bool((error[before] <= limits.speed_tolerance_rpm).all()),
        "worst_error_rpm": float(error[since].max()),
        "recovery_s": None if recovered is None else max(recovered - change_s, 0.0),
    }


def _settled(times: NDArray[np.float64], unsettled: NDArray[np.bool_]) -> float | None:
    """Return the time from which nothing is unsettled any more."""
    where = np.flatnonzero(unsettled)
    if not where.size:
        return float(times[0])
    last = int(where[-1])
    return None if last + 1 >= len(times) else float(times[last + 1])


def _columns(run: ClosedLoopRun) -> dict[str, NDArray[np.float64]]:
    return {name: run.trace[name] for name in observation.TRACE_COLUMNS}


def _trajectory(columns: dict[str, NDArray[np.float64]]) -> dict[str, list[float]]:
    """Thin a trace out to what a figure needs."""
    times = columns["time_s"]
    every = max(round(SHOWN_EVERY_S / float(times[1] - times[0])), 1)
    whole = len(times) // every * every
    error = (columns["speed_rpm"] - columns["speed_reference_rpm"])[:whole].reshape(-1, every)
    # Of each piece the largest error, so that no peak is lost.
    largest = error[np.arange(len(error)), np.abs(error).argmax(axis=1)]
    return {
        "time_s": [round(float(value), 6) for value in times[:whole:every]],
        "speed_error_rpm": [round(float(value), 3) for value in largest],
        "advance_deg": [round(float(value), 3) for value in columns["advance_deg"][:whole:every]],
        "current_sum_a": [
            round(float(value), 3)
            for value in columns["current_sum_a"][:whole].reshape(-1, every).mean(axis=1)
        ],
    }


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
) -> Iterator[Row]:
    """Return a candidate's points on a drive; two shares of a narrow range may be one speed."""
    points = [(index, planned) for index, planned in enumerate(plan) if planned.group == "points"]
    for share in EFFORTS[request.effort].speeds:
        speed = operating_speed(request.drive, share)
        for index, planned in points:
            if planned.speed_rpm != speed or index not in all_figures:
                continue
            load, figures = planned.scenario.load, all_figures[index]
            assert isinstance(load, ConstantTorqueLoad), "the load of an operating point is a torque"
            yield {**figures, **where_of(planned), "torque_nm": load.torque_nm, "speed_share": share}
