"""The recorded trace of a run: made from a run, or read from a result document that may contain anything."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Columns, RecordedTrace
from drivegate_cases.documents.document import parse_document
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


def _trace(scenario: Scenario, trace: object, judged_s: tuple[float, float]) -> RecordedTrace | None:
    columns = columns_of(trace, contract_of(scenario.drive).recorded_names)
    return None if columns is None else RecordedTrace(scenario, columns, judged_s)


def columns_of(trace: object, names: Iterable[str]) -> Columns | None:
    """Read columns; None unless all are there, equally long and finite, and time goes on."""
    if not isinstance(trace, Mapping):
        return None
    columns = {}
    for name in names:
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
