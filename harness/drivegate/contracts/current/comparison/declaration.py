"""Tables, ranking and page of a comparison of controllers with an advance angle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from math import inf
from typing import Any, Final

from drivegate.contracts.comparison import (
    POINTS,
    Column,
    Comparison,
    ComparisonRequest,
    Figure,
    PlannedRun,
    Population,
    Ranking,
    Row,
    RunTable,
    Words,
    mean_of,
    name_of,
)
from drivegate.contracts.current.comparison.best import best_jobs, best_tables
from drivegate.contracts.current.comparison.drive_cycle import TOLERANCE_KM_H, cycle_vehicle
from drivegate.contracts.current.comparison.measuring import (
    cycle_rows,
    disturbance_rows,
    drive_points,
    measured,
    point_rows,
    repeated_rows,
    trace_every,
)
from drivegate.contracts.current.comparison.page import SECTIONS, method, shown_facts
from drivegate.contracts.current.comparison.plan import EFFORTS, planned_runs
from drivegate.contracts.current.numbers import FEASIBLE, sensors_of
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of

_POWER: Final = Figure("input_power_w", "input power", "W", 1, above="power_above_{}_w")
_CURRENT: Final = Figure("current_sum_a", "Σ|i|", "A", above="current_above_{}_a")
_POWER_GAP: Final = Figure("gap_power_w", "power above best possible", "W", 1, signed=True)
_CURRENT_GAP: Final = Figure("gap_current_percent", "Σ|i| above best possible", "%", signed=True)
_CONVERGED: Final = Figure("converged_after_s", "converged after", "s")
_CANDIDATE: Final = name_of("candidate")
_BANDS_END_AT: Final = (0.3, 0.7, 1.0)
"""Ends of the bands of speed, shares of the range from base speed to the highest (1)."""


def _off_by(row: Row) -> str:
    return "yes" if row["held"] else f"off by {row['speed_error_rpm']:.0f} rpm"


def _recovery(row: Row) -> str:
    if row["recovery_s"] is not None:
        return f"{row['recovery_s']:.2f}"
    return "not held again" if row["held_before"] else "not held before"


def _by_disturbance(rows: Sequence[Row]) -> Sequence[Row]:
    order = list(dict.fromkeys(row["disturbance"] for row in rows))
    return sorted(rows, key=lambda row: order.index(row["disturbance"]))


def _with_noisy_mean(rows: Sequence[Row]) -> Sequence[Row]:
    """Return the runs with ideal sensors, each with the mean energy of those with noisy ones."""

    def noisy(candidate: str) -> str:
        runs = [row for row in rows if row["candidate"] == candidate and row["seed"] is not None]
        good = [row["energy_wh_per_km"] for row in runs if row["follows"]]
        if not good:
            return "does not follow" if runs else "–"
        lost = f" ({len(good)} of {len(runs)})" if len(good) < len(runs) else ""
        return f"{sum(good) / len(good):.2f}{lost}"

    return [{**row, "noisy": noisy(row["candidate"])} for row in rows if row["seed"] is None]


_POINT_COLUMNS: Final[tuple[Column, ...]] = (
    _CANDIDATE,
    Figure("speed_rpm", "speed", "rpm", 0),
    Figure("torque_nm", "load", "N·m"),
    Figure("load_percent", "of rated power", "%", 0),
    Words("held", _off_by, lambda row: "" if row["held"] else "fail"),
    _POWER,
    _CURRENT,
    _POWER_GAP,
    _CURRENT_GAP,
    Figure("ripple_percent", "ripple", "%", 1),
    Figure("advance_deg", "angle", "°", 1),
    Figure("above_edge_deg", "above feasible edge", "°", 1, signed=True),
    _CONVERGED,
)
_DISTURBANCE_COLUMNS: Final[tuple[Column, ...]] = (
    name_of("disturbance"),
    _CANDIDATE,
    Figure("worst_error_rpm", "worst speed error", "rpm", 1),
    Words("held again after (s)", _recovery, lambda row: "fail" if row["recovery_s"] is None else ""),
    Figure("input_power_w", "input power in the end", "W", 1),
    Figure("current_sum_a", "Σ|i| in the end", "A"),
)
_CYCLE_COLUMNS: Final[tuple[Column, ...]] = (
    _CANDIDATE,
    Words(
        "follows the cycle",
        lambda row: "yes" if row["follows"] else f"no, {row['outside_tolerance_s']:.1f} s outside",
        lambda row: "" if row["follows"] else "fail",
    ),
    Figure("energy_wh", "energy", "Wh"),
    Figure("distance_km", "distance", "km", 3),
    Figure("energy_wh_per_km", "Wh/km"),
    Words(
        "Wh/km, noisy sensors",
        lambda row: str(row["noisy"]),
        lambda row: "fail" if row["noisy"] == "does not follow" else "",
    ),
    *(
        Figure(f"energy_{phase}_wh", phase, "Wh")
        for phase in ("accelerating", "cruising", "slowing", "standing")
    ),
    Figure("current_sum_mean_a", "mean Σ|i|", "A"),
    Figure("tracking_error_rms_km_h", "speed error, rms", "km/h", 3),
    Figure("tracking_error_worst_km_h", "worst", "km/h", signed=True),
)
_TABLES: Final = (
    RunTable(
        name=POINTS,
        groups=("points",),
        rows=point_rows,
        columns=_POINT_COLUMNS,
        caption=lambda document: (
            "Means over what follows the time to converge, in "
            f"{document['drive'].get('change_s', 10.0):.0f} s at each point, ideal sensors."
        ),
    ),
    RunTable(
        name="disturbances",
        groups=("disturbances",),
        rows=disturbance_rows,
        columns=_DISTURBANCE_COLUMNS,
        caption=lambda _: (
            "Time from the end of the disturbance until the speed stays within k1, and means of what follows the time "
            "to converge. A step of the speed reference is a speed error at once."
        ),
        shown=_by_disturbance,
    ),
    RunTable(name="repetitions", groups=("noise", "drawn"), rows=repeated_rows),
    RunTable(
        name="drive_cycle",
        groups=("cycle",),
        rows=cycle_rows,
        columns=_CYCLE_COLUMNS,
        caption=lambda document: (
            "With ideal sensors, and the mean with noisy ones. Who is "
            f"{document['cycle']['tolerance_km_h']:g} km/h off has not driven the cycle, so that its energy is not "
            "comparable."
        ),
        shown=_with_noisy_mean,
    ),
)


def _standing(row: Row) -> Iterator[str]:
    if row["gap_power_w"] is not None:
        yield f"takes {row['gap_power_w']:.1f} W more than the best possible angle would, on average"


_RANKING: Final = Ranking(
    rule=(
        "most operating points held within k1, then least mean true input power over the points that all equals "
        "hold; means within 0.1 % share a place."
    ),
    decides="input_power_w",
    place=("speed_rpm", "load_percent"),
    count="points_feasible",
    same_share=0.001,
    summaries={
        POINTS: {
            "gap_power_w": ("gap_power_w", mean_of),
            "gap_current_percent": ("gap_current_percent", mean_of),
            "ripple_worst_percent": ("ripple_percent", "max"),
            "converged_after_s": ("converged_after_s", mean_of),
        }
    },
    costs=(_POWER, _CURRENT),
    columns=(
        _POWER,
        Figure("power_above_first_w", "above {first}", "W", 1, signed=True),
        _CURRENT,
        Figure("current_above_first_a", "above {first}", "A", signed=True),
        Figure("points_shared", "over points", digits=0),
        _POWER_GAP,
        _CURRENT_GAP,
        Figure("ripple_worst_percent", "worst ripple", "%", 1),
        _CONVERGED,
    ),
    printed=("power_above_first_w", "current_above_first_a", "gap_current_percent"),
    caption=lambda first: (
        f"Input power, Σ|i| and what they are above {first} are means over the points that both hold; the columns "
        "after them are about the points that the candidate holds itself, among those with a feasible angle. "
        f"{FEASIBLE}"
    ),
    standing=_standing,
    remark=f"points and the best possible are of feasible angles: {FEASIBLE}",
)
_ENERGY: Final = Figure("energy_wh_per_km", "energy", "Wh/km")
_POPULATIONS: Final = (
    Population(
        "drawn plants and noise",
        "repetitions",
        lambda runs: runs["group"] == "drawn",
        "held",
        (_POWER, _CURRENT),
    ),
    Population("", "repetitions", lambda runs: runs["group"] == "noise", "held", (_POWER, _CURRENT)),
    Population(
        "drive cycle, noisy sensors",
        "drive_cycle",
        lambda runs: runs["seed"].notna(),
        "follows",
        (_ENERGY, Figure("current_sum_mean_a", "Σ|i|, mean of the cycle", "A")),
    ),
)


def _ends_rpm(drive: DriveDocument) -> Sequence[float]:
    return (0.0, *map(scale_of(drive).speed, _BANDS_END_AT), inf)


def _facts(request: ComparisonRequest, plan: Sequence[PlannedRun]) -> Row:
    drive, cycle = request.drive, request.cycle
    size = asdict(EFFORTS[request.effort])
    del size["speeds"]
    speeds = dict.fromkeys(run.speed_rpm for run in plan if run.group == "points")
    return {
        "drive": {
            "speed_tolerance_rpm": limits_of(drive).speed_tolerance_rpm,
            "change_s": scale_of(drive).change_s,
            "sensors": sensors_of(drive),
        },
        "size": {"speeds_rpm": list(speeds)} | size,
        "cycle": {
            "name": cycle.name,
            "description": cycle.description,
            "source": cycle.source,
            "duration_s": cycle.duration_s,
            "distance_km": cycle.distance_m / 1000.0,
            "tolerance_km_h": TOLERANCE_KM_H,
            "vehicle": cycle_vehicle(drive).model_dump(mode="json", exclude={"kind", "grade_percent"}),
        },
    }


def _supply_voltage_v(drive: Any) -> float:
    return float(drive.inverter.supply_voltage_v)


COMPARISON: Final = Comparison(
    kind="comparison",
    plan=planned_runs,
    trace_every=trace_every,
    measure=measured,
    best=best_jobs,
    tables=_TABLES,
    best_tables=best_tables,
    curves={"trajectories": ("disturbances", "trajectory"), "cycle_samples": ("cycle", "samples")},
    ranking=_RANKING,
    region_ends_rpm=_ends_rpm,
    populations=_POPULATIONS,
    facts=_facts,
    supply_voltage_v=_supply_voltage_v,
    drive_points=drive_points,
    sections=SECTIONS,
    method=method,
    shown_facts=shown_facts,
)
"""How these controllers are compared."""
