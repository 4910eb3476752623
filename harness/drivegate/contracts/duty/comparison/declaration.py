"""Measures, tables, ranking and page of a comparison of controllers of duty ratios."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from typing import Any, Final

from drivegate.checks.check import Record
from drivegate.contracts.comparison import (
    HELD,
    POINTS,
    Column,
    Comparison,
    ComparisonRequest,
    Figure,
    PlannedRun,
    Ranking,
    Row,
    RunTable,
    mean_of,
    name_of,
)
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.comparison.page import SECTIONS, method, rise_percent, shown_facts
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.points import steady_points, step_rows
from drivegate.contracts.duty.scenarios.building import speed_scenario, torque_of, torque_scenario
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.scenarios.title import titled
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_models.machine.rotor_frame import SUM_OVER_PEAK

_SEARCH_S: Final = 6.0
"""Length of a run of a speed reference, in which a search of seconds finds its angle (s)."""
_STEPS: Final = (0.0, 0.5, 0.2, 0.8, 0.4)
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
            searched = on_whole_periods(_SEARCH_S, drive.control_period_s)
            whole = titled(run.replaced(duration_s=max(run.duration_s, searched)))
            yield PlannedRun("points", f"{torque:g} N·m at {speed:g} rpm", whole)


def _torques(drive: PmAcDocument, size: DutyEffort) -> Iterator[PlannedRun]:
    for speed in dict.fromkeys(speed_of(drive, share) for share in size.speeds):
        torques = [torque_of(drive, speed, share) for share in size.torques]
        yield PlannedRun("points", f"torques at {speed:g} rpm", torque_scenario(drive, speed, torques))
    for speed in dict.fromkeys(speed_of(drive, share) for share in size.step_speeds):
        torques = [torque_of(drive, speed, share) for share in _STEPS]
        yield PlannedRun("steps", f"steps at {speed:g} rpm", torque_scenario(drive, speed, torques))


_DIGITS: Final = 6
_LOSS: Final = Figure("loss_above_least_percent", "loss above least", "%")
_CURRENT: Final = Figure("current_above_least_percent", "current above least", "%")
_SPEED: Final = Figure("speed_rpm", "speed", "rpm", None)


def _measured(planned: PlannedRun, record: Record) -> Row:
    run = duty_record(record)
    return {planned.group: steady_points(run) if planned.group == "points" else list(step_rows(run))}


def _rows(planned: PlannedRun, figures: Row, _best: Row | None) -> Iterator[Row]:
    for row in figures[planned.group]:
        yield {key: _rounded(value) for key, value in row.items()}


def _rounded(value: Any) -> Any:
    # Smaller than that is what rounding leaves of none.
    return significant(round(value, _DIGITS), _DIGITS) + 0.0 if isinstance(value, float) else value


_POINT_COLUMNS: Final[tuple[Column, ...]] = (
    name_of("candidate"),
    _SPEED,
    Figure("reference_nm", "asked", "N·m", None),
    Figure("torque_nm", "torque", "N·m", None),
    HELD,
    Figure("direct_current_a", "d", "A", None),
    Figure("quadrature_current_a", "q", "A", None),
    _CURRENT,
    Figure("input_power_w", "input", "W", None),
    Figure("loss_w", "loss", "W", None),
    _LOSS,
    Figure("efficiency_percent", "efficiency", "%"),
    Figure("voltage_percent", "voltage", "%", 1),
    Figure("ripple_percent", "ripple", "%"),
)
_STEP_COLUMNS: Final[tuple[Column, ...]] = (
    name_of("candidate"),
    _SPEED,
    Figure("before_nm", "from", "N·m", None),
    Figure("after_nm", "to", "N·m", None),
    Figure("rise_ms", "rise", "ms"),
    Figure("allowed_ms", "allowed", "ms"),
    Figure("overshoot_percent", "overshoot", "%"),
)
_TABLES: Final = (
    RunTable(
        name=POINTS,
        groups=("points",),
        rows=_rows,
        columns=_POINT_COLUMNS,
        caption=lambda _: (
            "Torque asked for, or of the load. Currents and losses of the fundamental compared with the least for the "
            "same torque; voltage of the undistorted."
        ),
    ),
    RunTable(
        name="steps",
        groups=("steps",),
        rows=_rows,
        columns=_STEP_COLUMNS,
        caption=lambda _: "Steps of the torque reference for which the voltage leaves room.",
    ),
)


def _standing(row: Row) -> Iterator[str]:
    if row["loss_above_least_percent"] is not None:
        yield (
            f"loses {row['loss_above_least_percent']:.2f} % more than the least on average, at worst "
            f"{row['loss_worst_percent']:.2f} %"
        )


_RANKING: Final = Ranking(
    rule=(
        "most operating points held, then least mean loss above the least possible over the points that all equals "
        "hold; means within 0.1 % share a place."
    ),
    decides="loss_above_least_percent",
    at_shared="loss_at_shared_percent",
    place=("speed_rpm", "reference_nm"),
    count="points",
    same_amount=0.1,
    summaries={
        POINTS: {
            "loss_above_least_percent": ("loss_above_least_percent", mean_of),
            "loss_worst_percent": ("loss_above_least_percent", "max"),
            "current_above_least_percent": ("current_above_least_percent", mean_of),
            "ripple_worst_percent": ("ripple_percent", "max"),
        },
        "steps": {
            "overshoot_worst_percent": ("overshoot_percent", "max"),
            # Where one is not known, the worst is not known either.
            "rise_worst_percent_of_allowed": (rise_percent, lambda rise: rise.max(skipna=False)),
        },
    },
    columns=(
        _LOSS,
        _CURRENT,
        Figure("ripple_worst_percent", "worst ripple", "%"),
        Figure("overshoot_worst_percent", "worst overshoot", "%"),
        Figure("rise_worst_percent_of_allowed", "worst rise of allowed", "%", 0),
    ),
    caption=lambda _: (
        "How many required checks are failed and how many operating points held; then means and worst values over the "
        "points that a candidate holds, ripple over rated torque, rise time over the longest that is allowed."
    ),
    standing=_standing,
)


def _facts(request: ComparisonRequest, _plan: Sequence[PlannedRun]) -> Row:
    limits = limits_of(request.drive)
    return {
        "reference": request.reference,
        "drive": {
            "rated_torque_nm": request.drive.rating.rated_torque_nm,
            "torque_tolerance_nm": limits.torque_error_nm,
            "speed_tolerance_rpm": limits.speed_tolerance_rpm,
            "overshoot_limit_percent": 100.0 * limits.overshoot,
        },
        "size": {"torques": list(EFFORTS[request.effort].torques)},
    }


def _place(speed_rpm: float, torque_nm: float) -> tuple[float, float]:
    return round(speed_rpm, _DIGITS), round(torque_nm, _DIGITS)


def _drive_points(
    request: ComparisonRequest, _plan: Sequence[PlannedRun], all_figures: Mapping[int, Row]
) -> Iterator[Row]:
    drive, size = duty_document(request.drive), EFFORTS[request.effort]
    rated_torque = drive.rating.rated_torque_nm
    rows = [row for figures in all_figures.values() for row in figures.get("points", ())]
    by_place = {_place(row["speed_rpm"], row["reference_nm"]): row for row in rows}
    for share in size.speeds:
        speed = speed_of(drive, share)
        for load in size.torques:
            row = by_place.get(_place(speed, torque_of(drive, speed, load)))
            if row is not None:
                yield _drive_point(share, load, rated_torque, row)


def _drive_point(share: float, load: float, rated_torque_nm: float, row: Row) -> Row:
    swing = row["ripple_percent"] * rated_torque_nm
    return {
        "speed_share": share,
        "load_percent": round(100.0 * load, _DIGITS),
        "speed_rpm": row["speed_rpm"],
        "torque_nm": row["reference_nm"],
        "held": row["held"],
        # The shaft is held at its speed, or follows it within the tolerance of what is held.
        "speed_mean_rpm": row["speed_rpm"],
        "torque_mean_nm": row["torque_nm"],
        "input_power_w": row["input_power_w"],
        "current_sum_a": SUM_OVER_PEAK * hypot(row["direct_current_a"], row["quadrature_current_a"]),
        "ripple_percent": swing / abs(row["torque_nm"]) if row["torque_nm"] else 0.0,
    }


def _supply_voltage_v(drive: Any) -> float:
    return float(drive.inverter.link_voltage_v)


COMPARISON: Final = Comparison(
    kind="duty-comparison",
    ignores="such controllers are compared at constant speeds without noise",
    plan=planned_duty_runs,
    measure=_measured,
    tables=_TABLES,
    curves={},
    ranking=_RANKING,
    facts=_facts,
    supply_voltage_v=_supply_voltage_v,
    drive_points=_drive_points,
    sections=SECTIONS,
    method=method,
    shown_facts=shown_facts,
)
"""How these controllers are compared."""
