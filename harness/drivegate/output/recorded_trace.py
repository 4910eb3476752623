"""The recorded trace of a run, taken out of a result document that may hold anything."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

_MOST_POINTS: Final = 5_000
_GREATEST: Final = 1e9

Columns = dict[str, NDArray[np.float64]]
"""Arrays of equal length, shape (n,), by the name of the column, which has the unit."""


@dataclass(frozen=True)
class RecordedTrace:
    """What is kept of a run.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    columns : dict
        Its signals, arrays of equal length by name.
    judged_s : tuple of float
        Start and end of the stretch that the check was judged on (s).
    """

    scenario: Scenario
    columns: Columns
    judged_s: tuple[float, float]


def recorded_trace(
    document: Mapping[str, Any], check: Mapping[str, Any], names: Iterable[str]
) -> RecordedTrace | None:
    """Find the recorded columns of the run that is shown for a check; None unless all of them are there."""
    recording, traces = check.get("recording"), document.get("traces")
    scenario = check.get("scenario") if check.get("counterexample") is None else check["counterexample"]
    if not isinstance(recording, Mapping) or not isinstance(traces, list):
        return None
    place = recording.get("trace")
    if not isinstance(place, int) or not 0 <= place < len(traces):
        return None
    columns = columns_of(traces[place], names)
    judged = (recording.get("start_s"), recording.get("end_s"))
    if columns is None or not all(isinstance(time, int | float) and math.isfinite(time) for time in judged):
        return None
    try:
        run = parse_document(scenario if isinstance(scenario, Mapping) else {}, Scenario, "the scenario")
    except InputError:
        return None
    return RecordedTrace(run, columns, (float(judged[0] or 0.0), float(judged[1] or 0.0)))


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
