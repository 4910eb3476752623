"""The recorded trace of a run, and its deciding moment at full resolution: made from a run, or read from a result."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from drivegate.checks.check import Check, Record
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Moment
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Columns, RecordedTrace
from drivegate_cases.documents.document import Section, parse_document
from drivegate_cases.documents.wording import significant
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

MOST_POINTS: Final = 300
"""Maximum number of points recorded of a run, each the mean of a stretch of it."""
_DIGITS: Final = 5
_TIME_DIGITS: Final = 9
"""Enough to distinguish control periods late in a run."""
_MOST_POINTS: Final = 5_000
_GREATEST: Final = 1e9
_MOST_ROWS: Final = 600
_CONTEXT: Final = 0.25


def recorded_trace(document: Mapping[str, Any], check: Mapping[str, Any]) -> RecordedTrace | None:
    """Read the recorded columns of the run that is shown for a check; None unless all of its contract are there."""
    recording, traces = check.get("recording"), document.get("traces")
    scenario = check.get("scenario") if check.get("counterexample") is None else check["counterexample"]
    if not isinstance(recording, Mapping) or not isinstance(traces, list):
        return None
    place = recording.get("trace")
    if not isinstance(place, int) or not 0 <= place < len(traces):
        return None
    judged = (recording.get("start_s"), recording.get("end_s"))
    if not all(isinstance(time, int | float) and math.isfinite(time) for time in judged):
        return None
    try:
        run = parse_document(scenario if isinstance(scenario, Mapping) else {}, Scenario, "the scenario")
    except InputError:
        return None
    return _trace(run, traces[place], (float(judged[0] or 0.0), float(judged[1] or 0.0)))


def trace_of_run(scenario: Scenario, run: Any, judged_s: tuple[float, float]) -> RecordedTrace | None:
    """Return the trace of a finished run as a result would record it."""
    return _trace(scenario, thinned(contract_of(scenario.drive).recorded_signals(run)), judged_s)


def shown_signals(record: Record) -> Columns:
    """Return the columns of a run that a result keeps: its trace, and what was sensed where that was kept."""
    contract = contract_of(record.scenario.drive)
    columns = contract.recorded_signals(record.run)
    if record.steps is None:
        return columns
    sensed = contract.sensed_signals(record.scenario, record.run, record.steps)
    return columns | {name: sensed[name] for name in contract.further_names if name in sensed}


def _trace(scenario: Scenario, trace: object, judged_s: tuple[float, float]) -> RecordedTrace | None:
    contract = contract_of(scenario.drive)
    columns = columns_of(trace, contract.recorded_names, contract.further_names)
    return None if columns is None else RecordedTrace(scenario, columns, judged_s)


def columns_of(trace: object, names: Iterable[str], further: Iterable[str] = ()) -> Columns | None:
    """Read columns; None unless all are there, equally long and finite, and time goes on. Some may be missing."""
    if not isinstance(trace, Mapping):
        return None
    columns = {}
    for name in (*names, *(name for name in further if name in trace)):
        values = trace.get(name)
        if not isinstance(values, list) or not 2 <= len(values) <= _MOST_POINTS:
            return None
        if not all(isinstance(value, int | float) and abs(value) < _GREATEST for value in values):
            return None
        columns[name] = np.array(values, dtype=np.float64)
    lengths = {len(values) for values in columns.values()}
    if len(lengths) != 1 or not np.all(np.diff(columns["time_s"]) > 0.0):
        return None
    return columns


def thinned(whole: Mapping[str, NDArray[Any]], most: int = MOST_POINTS) -> dict[str, list[float]]:
    """Take the means of columns over equal stretches, at most so many of them."""
    rows = len(next(iter(whole.values())))
    length = max(-(-rows // most), 1)
    begins = np.arange(0, rows, length)
    counts = np.diff(np.append(begins, rows))
    columns = {}
    for name, values in whole.items():
        means = np.add.reduceat(values, begins) / counts
        digits = _TIME_DIGITS if name == "time_s" else _DIGITS
        columns[name] = [significant(mean, digits) for mean in means]
    return columns


class Closeup(Section):
    """The deciding moment of a run and its signals there."""

    moment: Moment = Field(description="the stretch of the run that decides")
    columns: dict[str, tuple[float, ...]] = Field(
        description="signals around it, control period by control period where they are few enough, as in 'traces'"
    )


def deciding_moment(check: Check, record: Record, margin: Margin | None) -> Moment:
    """Return the moment that a check states for a run, else the stretch that its contract judges."""
    stated = None if margin is None else check.moment(record)
    if stated is not None:
        return stated
    start, end = contract_of(record.scenario.drive).judged_window(check, record, margin)
    return Moment(start_s=start, end_s=end)


def closeup_of(record: Record, moment: Moment) -> dict[str, Any] | None:
    """Return the close-up of a moment as plain data; None where that would be the whole run, unmarked."""
    columns = shown_signals(record)
    time = columns["time_s"]
    # A stretch without a column of its own is shown with what leads to it.
    before = 0.0 if moment.is_marked else _CONTEXT * (moment.end_s - moment.start_s)
    rows = np.flatnonzero((time >= moment.start_s - before) & (time <= moment.end_s))
    is_marked = bool(moment.courses) or moment.column in columns
    if len(rows) < 2 or (len(rows) == len(time) and not is_marked):
        return None
    shown = {name: values[rows[0] : rows[-1] + 1] for name, values in columns.items()}
    if is_marked and not moment.courses and len(rows) > _MOST_ROWS:
        # Means of several control periods would not show what only one of them does.
        course = course_of(moment.column, shown["time_s"], shown[moment.column])
        moment = moment.model_copy(update={"courses": (course,)})
    return {"moment": moment.model_dump(mode="json"), "columns": thinned(shown, _MOST_ROWS)}


def recorded_closeup(
    check: Mapping[str, Any], names: tuple[str, ...], further: tuple[str, ...] = ()
) -> tuple[Moment, Columns] | None:
    """Read the close-up of the run that is shown for a check; None unless all columns of its contract are there."""
    recording = check.get("recording")
    if not isinstance(recording, Mapping) or recording.get("closeup") is None:
        return None
    try:
        read = Closeup.model_validate_json(json.dumps(recording["closeup"]))
    except (ValidationError, TypeError, ValueError):
        return None
    columns = columns_of({name: list(values) for name, values in read.columns.items()}, names, further)
    return None if columns is None else (read.moment, columns)
