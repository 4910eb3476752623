"""From a finished run and a row to the margin by which the run meets it, and the moment that decides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from drivegate.checks.check import Record
from drivegate.checks.margin import Margin, Mark, Moment, Point, normalised
from drivegate.contracts.contract import Columns, Contract
from drivegate.contracts.rows.statistics import MEASURES, Extremes, Values, place_reached
from drivegate.contracts.rows.windows import Span, is_asked_for, judged_spans, stretch_periods
from drivegate_cases.documents.wording import figure
from drivegate_cases.requirements.quantities import QUANTITIES, Quantity
from drivegate_cases.requirements.row import Row

_PARTIAL = ("value", "absolute")
"""Statistics that mean the same over a part of a window."""
_COUNTED = ("peak", "peak to peak", "sign changes")
"""Statistics that grow with the window, so that a part of it can break an upper limit."""


@dataclass(frozen=True)
class Judged:
    """One window with what a row says of it."""

    value: float
    """The margin."""
    measured: float
    span: Span
    at: int
    """Control period in which it was measured."""
    note: str = ""


class _Signals(dict[str, Values]):
    """The signals of a run, each made when it is first asked for."""

    def __init__(self, contract: Contract, run: Any) -> None:
        super().__init__()
        self._contract, self._run = contract, run

    def __missing__(self, name: str) -> Values:
        self[name] = self._contract.signal(self._run, name)
        return self[name]


def signals_of(contract: Contract, record: Record) -> Columns:
    """Return the signals of a run, which all rows share."""
    if "signals" not in record.derived:
        record.derived["signals"] = _Signals(contract, record.run)
    columns: Columns = record.derived["signals"]
    return columns


def worst_window(row: Row, contract: Contract, record: Record) -> Judged | None:
    """Judge every window of a run; None where there is none."""
    if not is_asked_for(row, contract, record.scenario):
        return None
    judged = list(_windows(row, contract, record))
    return min(judged, key=lambda each: each.value, default=None)


def _windows(row: Row, contract: Contract, record: Record) -> Iterator[Judged]:
    scenario, columns = record.scenario, signals_of(contract, record)
    quantity = QUANTITIES[row.quantity]
    values = quantity.compute(columns, scenario.drive)
    stretch = stretch_periods(row, scenario)
    for span in judged_spans(row, contract, scenario, columns):
        inside = values[span.start : span.end]
        if row.statistic == "time until":
            judged = _time_until(row, inside, span, scenario.control_period_s, stretch or None)
        elif len(inside) < max(stretch, 1) or not (stretch or span.is_whole or _judges_part(row)):
            judged = None
        else:
            scale = quantity.scale(scenario.drive)
            judged = _limited(row, MEASURES[row.statistic](inside, stretch), span, scale)
        if judged is not None:
            yield judged


def _judges_part(row: Row) -> bool:
    """Return True if a window that is cut short can be judged."""
    return row.statistic in _PARTIAL or (row.statistic in _COUNTED and row.limits[0] is None)


def _limited(row: Row, found: Extremes, span: Span, scale: float) -> Judged:
    """Compare what was measured with the limits; the nearer one decides."""
    low, high = row.limits
    sides = []
    if low is not None:
        sides.append((_share(found.low - low, row, low, scale), found.low, found.low_at))
    if high is not None:
        sides.append((_share(high - found.high, row, high, scale), found.high, found.high_at))
    value, measured, at = min(sides)
    return Judged(value, measured, span, span.start + at)


def _share(distance: float, row: Row, limit: float, scale: float) -> float:
    """Return a distance from a limit over it: over half of a range, and over the rating where the limit is 0."""
    if row.within is not None:
        return normalised(distance, 0.5 * (row.within[1] - row.within[0]))
    return normalised(distance, abs(limit) or scale)


def _time_until(row: Row, inside: Values, span: Span, period: float, stretch: int | None) -> Judged | None:
    assert row.until is not None, "a row that waits states for what"
    if len(inside) == 0:
        return None
    low, high = row.until
    place = place_reached(inside, low, high, stretch)
    if place is not None:
        at = span.start + place
        return _limited(row, _instant(max(at * period - span.origin_s, 0.0)), span, 1.0)
    last = span.end * period - span.origin_s
    upper = row.limits[1]
    # A window that ended before the limit shows nothing: it might have been reached in time.
    if upper is None or last <= upper:
        return None
    distance = max(low - inside[-1], inside[-1] - high, 0.0)
    width = (high - low) or 1.0
    judged = _limited(row, _instant(last * (1.0 + min(float(distance) / width, 1.0))), span, 1.0)
    return Judged(judged.value, last, span, span.end - 1, "not reached within")


def _instant(time_s: float) -> Extremes:
    return Extremes(time_s, 0, time_s, 0)


def margin_of(row: Row, contract: Contract, record: Record) -> Margin | None:
    """Judge a run by a row."""
    judged = worst_window(row, contract, record)
    if judged is None:
        return None
    if not math.isfinite(judged.measured):
        return Margin(row.id, normalised(math.nan, 1.0), f"{named_statistic(row)} is not finite")
    words = _measured_in_words(row, QUANTITIES[row.quantity], judged, record)
    return Margin(row.id, judged.value, words)


def _measured_in_words(row: Row, quantity: Quantity, judged: Judged, record: Record) -> str:
    at = judged.at * record.scenario.control_period_s
    since = f" after {when_in_words(row)} at {figure(judged.span.origin_s)} s"
    if row.statistic == "time until":
        words = f"{judged.note} " if judged.note else ""
        return f"{quantity.words}: {words}{figure(judged.measured)} s{since}"
    unit = "" if row.statistic == "sign changes" else f" {quantity.unit}"
    words = f"{named_statistic(row)} {figure(judged.measured)}{unit}"
    if row.statistic in ("mean", "rms", "peak to peak", "sign changes"):
        period = record.scenario.control_period_s
        begin, end = judged.span.start * period, judged.span.end * period
        return f"{words} from {figure(begin)} to {figure(end)} s"
    words += f" at {figure(at)} s"
    return words if not row.when.event else f"{words}, {figure(max(at - judged.span.origin_s, 0.0))} s{since}"


def named_statistic(row: Row) -> str:
    """Return what a row limits, in words."""
    words = QUANTITIES[row.quantity].words
    if row.statistic == "value":
        return words
    return f"sign changes of the {words}" if row.statistic == "sign changes" else f"{row.statistic} {words}"


def when_in_words(row: Row) -> str:
    """Return what a row waits for, with its article where it has one."""
    event = row.when.event
    if event is None:
        return "the state" if row.when.has_state else "the start"
    return {"start": "the start", "end of a change": "the end of a change"}.get(event, f"the {event}")


def moment_of(row: Row, contract: Contract, record: Record) -> Moment | None:
    """Return the window that decides, with the limits in it as values of the signal that figures show."""
    judged = worst_window(row, contract, record)
    if judged is None or not math.isfinite(judged.measured):
        return None
    period, columns = record.scenario.control_period_s, signals_of(contract, record)
    quantity, span = QUANTITIES[row.quantity], judged.span
    column = quantity.shown if quantity.shown in contract.recorded_names else ""
    start, end = min(span.origin_s, span.start * period), span.end * period
    if not column:
        return Moment(start_s=start, end_s=end, origin_s=span.origin_s)
    at = min(judged.at, len(columns[column]) - 1)
    return Moment(
        start_s=start,
        end_s=end,
        column=column,
        origin_s=span.origin_s,
        levels=_levels(row, quantity, columns, at),
        point=Point(
            words=f"{quantity.words} {figure(judged.measured)}",
            time_s=float(columns["time_s"][at]),
            value=float(columns[column][at]),
        ),
    )


def _levels(row: Row, quantity: Quantity, columns: Columns, at: int) -> tuple[Mark, ...]:
    """Return the limits, about what the signal is meant to follow."""
    if row.statistic not in ("value", "absolute", "peak", "time until"):
        return ()
    around = float(columns[quantity.around][at]) if quantity.around else 0.0
    limits = row.until if row.until is not None else row.limits
    if row.statistic in ("absolute", "peak") and limits[1] is not None:
        limits = (-limits[1], limits[1])
    words = "range" if row.until is not None else "limit"
    return tuple(
        Mark(words=f"{words} {figure(limit)} {quantity.unit}", value=around + limit)
        for limit in limits
        if limit is not None
    )
