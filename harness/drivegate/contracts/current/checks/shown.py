"""What figures show of a window or of a place in a run: the moment that decides a check."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.course import course_of
from drivegate.checks.margin import GREATEST, Course, Margin, Mark, Moment, Point, worst_required
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow
from drivegate.contracts.current.run import observed_windows
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.limits import limits_of, mean_time

SHOWN_PERIODS: Final = 100
"""Control periods before and after the deciding one that figures show."""
_RIPPLE_TIME: Final = 1.0


def decisive(judged: Iterable[tuple[SteadyWindow, Margin | None]]) -> SteadyWindow | None:
    """Return the window whose margin decides; None where none is judged."""
    known = [(window, margin) for window, margin in judged if margin is not None]
    worst = worst_required([margin for _, margin in known])
    return next((window for window, margin in known if margin is worst), None)


def rows_of(record: CurrentRecord, window: SteadyWindow) -> slice:
    """Return the rows of the trace in a window."""
    start = next(start for start, end in observed_windows(record.scenario) if end == window.dwell.end)
    times = record.run.trace["time_s"]
    half = 0.5 * record.scenario.control_period_s
    return slice(
        int(np.searchsorted(times, start - half)), int(np.searchsorted(times, window.dwell.end - half))
    )


def speed_moment(record: CurrentRecord, window: SteadyWindow) -> Moment:
    """Show the speed in a window, with the place of its greatest error and with k1."""
    rows, wanted = rows_of(record, window), window.dwell.speed_rpm
    speed = record.run.trace["speed_rpm"][rows]
    place = int(np.argmax(np.abs(speed - wanted)))
    allowed = limits_of(record.scenario.drive).speed_tolerance_rpm
    return _column(
        record,
        window,
        rows,
        "speed_rpm",
        place,
        f"{figure(abs(float(speed[place]) - wanted))} rpm off",
        (("reference", wanted), ("+ k1", wanted + allowed), ("- k1", wanted - allowed)),
    )


def angle_moment(record: CurrentRecord, window: SteadyWindow) -> Moment:
    """Show the advance angle in a window, between its extremes."""
    rows = rows_of(record, window)
    angle = record.run.trace["advance_deg"][rows]
    least, greatest = float(np.min(angle)), float(np.max(angle))
    allowed = limits_of(record.scenario.drive).angle_tolerance_deg
    words = f"moves by {greatest - least:.3g}°"
    levels = ("least", least), (f"limit {least + allowed:.4g}°", least + allowed)
    return _column(record, window, rows, "advance_deg", int(np.argmax(angle)), words, levels)


def spread_moment(record: CurrentRecord, window: SteadyWindow) -> Moment:
    """Show the means of the current sum in a window, between their extremes."""
    rows, drive = rows_of(record, window), record.scenario.drive
    times, sums = record.run.trace["time_s"][rows], record.run.trace["current_sum_a"][rows]
    step = float(times[1] - times[0])
    block = max(round(mean_time(drive) / step), 1)
    count = len(sums) // block
    means = sums[: count * block].reshape(count, block).mean(axis=1)
    begins = times[: count * block : block]
    least, greatest = float(np.min(means)), float(np.max(means))
    place = int(np.argmax(means))
    mean = window.values.current_sum
    return Moment(
        start_s=float(times[0]),
        end_s=window.dwell.end,
        quantity=f"mean of Σ|i| over {mean_time(drive):g} s (A)",
        courses=(course_of("mean", begins, means),),
        levels=(Mark(words="least", value=least), Mark(words=f"mean {mean:.4g} A", value=mean)),
        point=Point(
            words=f"varies by {100.0 * (greatest - least) / mean:.3g} %",
            time_s=float(begins[place]),
            value=greatest,
        ),
    )


def _column(
    record: CurrentRecord,
    window: SteadyWindow,
    rows: slice,
    column: str,
    place: int,
    words: str,
    levels: Iterable[tuple[str, float]],
) -> Moment:
    times = record.run.trace["time_s"]
    return Moment(
        start_s=float(times[rows.start]),
        end_s=window.dwell.end,
        column=column,
        levels=tuple(Mark(words=named, value=value) for named, value in levels),
        point=Point(
            words=words,
            time_s=float(times[rows.start + place]),
            value=float(record.run.trace[column][rows.start + place]),
        ),
    )


def around(
    times: NDArray[Any],
    place: int,
    courses: Sequence[tuple[str, NDArray[np.float64]]],
    quantity: str,
    levels: Iterable[tuple[str, float]],
    words: str,
) -> Moment:
    """Show courses around a place, which is marked on the first of them; `times`, shape (n,), are in seconds."""
    rows = slice(max(place - SHOWN_PERIODS, 0), place + SHOWN_PERIODS + 1)
    shown = times[rows]
    drawn: list[Course] = [course_of(name, shown, values[rows]) for name, values in courses]
    return Moment(
        start_s=float(shown[0]),
        end_s=float(shown[-1]),
        quantity=quantity,
        courses=tuple(drawn),
        levels=tuple(Mark(words=named, value=value) for named, value in levels),
        point=Point(
            words=words,
            time_s=float(times[place]),
            value=float(np.clip(np.nan_to_num(courses[0][1][place]), -GREATEST, GREATEST)),
        ),
    )


def ripple_rows(record: CurrentRecord, window: SteadyWindow) -> slice:
    """Return the rows of a window in which the ripple of its torque is observed; empty where none are recorded."""
    rows, trace = rows_of(record, window), record.run.trace
    begin = float(trace["time_s"][rows.stop - 1]) - _RIPPLE_TIME
    seen = np.flatnonzero(np.isfinite(trace["torque_lowest_nm"][rows]) & (trace["time_s"][rows] >= begin))
    return slice(rows.start + int(seen[0]), rows.start + int(seen[-1]) + 1) if seen.size else slice(0, 0)


def cycle_moment(record: CurrentRecord, window: SteadyWindow, words: str, allowed: float) -> Moment | None:
    """Show the extremes of the torque in the electrical period of a window that has the most ripple."""
    rows, trace = ripple_rows(record, window), record.run.trace
    drive = record.scenario.drive
    step = float(trace["time_s"][1] - trace["time_s"][0])
    cycle = math.ceil(2.0 * math.pi / (drive.machine.pole_pairs * max(window.values.speed, 1e-9) * step))
    count = rows.stop - rows.start - cycle
    if count <= 0:
        return None
    lowest, highest, mean = (
        trace[name][rows] for name in ("torque_lowest_nm", "torque_highest_nm", "torque_nm")
    )
    seen: NDArray[Any] = np.lib.stride_tricks.sliding_window_view(highest, cycle).max(axis=1)
    swings = seen - np.lib.stride_tricks.sliding_window_view(lowest, cycle).min(axis=1)
    first = int(np.argmax(swings))
    shown = slice(first, first + cycle)
    times = trace["time_s"][rows][shown]
    least, average = float(np.min(lowest[shown])), float(np.mean(mean[shown]))
    place = int(np.argmax(highest[shown]))
    return Moment(
        start_s=float(times[0]),
        end_s=float(times[-1]) + step,
        quantity="torque (N·m)",
        courses=(course_of("greatest", times, highest[shown]), course_of("least", times, lowest[shown])),
        levels=(
            Mark(words="least", value=least),
            Mark(words=f"limit {least + allowed * average:.4g} N·m", value=least + allowed * average),
        ),
        point=Point(words=words, time_s=float(times[place]), value=float(highest[shown][place])),
    )
