"""Check of the current along the magnet's axis behind steps of the torque reference."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import SHOWN_BEFORE, worst
from drivegate.contracts.duty.checks.steps import (
    TorqueStep,
    is_free,
    least_state,
    torque_steps,
    voltage_time_s,
)
from drivegate.contracts.duty.current_bandwidth import OF_ONE_LEG, transient_periods
from drivegate.contracts.duty.record import DutyRecord

LINEAR_SHARE = 0.5
"""Time that the voltage takes to move the currents, over the stated rise time, up to which a step is judged (1)."""
_LEVEL_PERIODS = 25


def decoupled_current(record: DutyRecord) -> Margin | None:
    return worst(_moved(record, step) for step in _judged_steps(record))


def coupling_moment(record: DutyRecord) -> Moment | None:
    """Show the d current after the step that moves it most, with the range that it is allowed."""
    step = min(_judged_steps(record), key=lambda step: _moved(record, step).value, default=None)
    if step is None:
        return None
    period = record.scenario.control_period_s
    direct, rows, (least, greatest), allowed = _course(record, step)
    outside = np.maximum(least - direct[rows], direct[rows] - greatest)
    place = rows.start + int(np.argmax(outside))
    return Moment(
        start_s=max(step.time_s - SHOWN_BEFORE * period, 0.0),
        end_s=rows.stop * period,
        column="direct_current_a",
        origin_s=step.time_s,
        levels=(
            Mark(words=f"limit {greatest + allowed:.3g} A", value=greatest + allowed),
            Mark(words=f"limit {least - allowed:.3g} A", value=least - allowed),
        ),
        point=Point(
            words=f"{max(float(np.max(outside)), 0.0):.3g} A beyond",
            time_s=(place + 0.5) * period,
            value=float(direct[place]),
        ),
    )


def _judged_steps(record: DutyRecord) -> Iterator[TorqueStep]:
    longest = LINEAR_SHARE * record.limits.rise_time_s
    for step in torque_steps(record) if record.is_nominal else ():
        if is_free(record, step) and voltage_time_s(record, step) <= longest:
            yield step


def _course(
    record: DutyRecord, step: TorqueStep
) -> tuple[NDArray[np.float64], slice, tuple[float, float], float]:
    """Return the d current (A), the judged control periods, its range before and after them, and what is allowed."""
    begin = step.rows.start
    end = min(begin + transient_periods(record.document, record.declaration), step.rows.stop)
    direct = record.run.column("direct")
    ranges = [
        _range_about(direct[place - _LEVEL_PERIODS : place], direct[steady])
        for place, steady in zip((begin, end), step.steady, strict=True)
    ]
    levels = (min(least for least, _ in ranges), max(greatest for _, greatest in ranges))
    allowed = record.limits.coupling * _step_size(record, step) + _disturbance(record)
    return direct, slice(begin, end), levels, allowed


def _disturbance(record: DutyRecord) -> float:
    """Return what a leg moves the d current by in a control period in which its own current changes sign (A).

    What dead time and drop take from it then changes sign, which no controller can answer before the next period.
    """
    changed = 2.0 * OF_ONE_LEG * record.document.inverter.lost_voltage_v
    return changed * (record.scenario.control_period_s / record.plant.direct_inductance)


def _range_about(level: NDArray[np.float64], steady: NDArray[np.float64]) -> tuple[float, float]:
    """Return the range of a current (A) about its level, with the ripple that it has where it is steady."""
    mean, middle = exact_mean(level), exact_mean(steady)
    return mean + float(np.min(steady)) - middle, mean + float(np.max(steady)) - middle


def _step_size(record: DutyRecord, step: TorqueStep) -> float:
    """Return the step of the q current (A)."""
    first, last = (least_state(record, step, torque).quadrature for torque in (step.before, step.after))
    return abs(last - first)


def _moved(record: DutyRecord, step: TorqueStep) -> Margin:
    direct, rows, (least, greatest), allowed = _course(record, step)
    judged = direct[rows]
    moved = max(least - float(np.min(judged)), float(np.max(judged)) - greatest, 0.0)
    size = _step_size(record, step)
    measured = (
        f"d current moved by {moved:.4g} A by a q step of {size:.4g} A, from {step.before:.4g} to {step.after:.4g} N·m "
        f"at {step.speed_rpm:.5g} rpm"
    )
    return Margin("DEC-1", at_most(moved, allowed), measured)


DEC_1 = Check(
    id="DEC-1",
    families=("torque step",),
    requirement=(
        "A step of the torque moves the d current beyond its values before and after by at most {coupling} of "
        "the step of the q current, plus what dead time and drop of one leg move it by when its current changes sign."
    ),
    limit="{coupling} of the step of the q current, plus dead time and drop of one leg when its current changes sign",
    scenarios="steps of 10 % of rated torque and more on the nominal drive, so small that no voltage is limited",
    formula="1 - d current outside of its values before and {transient} after / the limit",
    why="Rotation couples both axes, and what is not decoupled is current and loss for nothing.",
    evaluate=decoupled_current,
    moment=coupling_moment,
)
