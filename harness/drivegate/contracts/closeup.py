"""The deciding moment of a run with its signals at full resolution: made from a run, or read from a result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from pydantic import Field, ValidationError

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment
from drivegate.checks.record import Record
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Columns
from drivegate.contracts.recorded_trace import columns_of, thinned
from drivegate_cases.documents.document import Section

_MOST_ROWS: Final = 600
_CONTEXT: Final = 0.25


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
    columns = contract_of(record.scenario.drive).recorded_signals(record.run)
    time = columns["time_s"]
    # A stretch without a column of its own is shown with what leads to it.
    before = 0.0 if moment.column else _CONTEXT * (moment.end_s - moment.start_s)
    rows = np.flatnonzero((time >= moment.start_s - before) & (time <= moment.end_s))
    is_marked = bool(moment.column) and moment.column in columns
    if len(rows) < 2 or (len(rows) == len(time) and not is_marked):
        return None
    shown = {name: values[rows[0] : rows[-1] + 1] for name, values in columns.items()}
    return {"moment": moment.model_dump(mode="json"), "columns": thinned(shown, _MOST_ROWS)}


def recorded_closeup(check: Mapping[str, Any], names: tuple[str, ...]) -> tuple[Moment, Columns] | None:
    """Read the close-up of the run that is shown for a check; None unless all columns of its contract are there."""
    recording = check.get("recording")
    if not isinstance(recording, Mapping) or recording.get("closeup") is None:
        return None
    try:
        read = Closeup.model_validate_json(json.dumps(recording["closeup"]))
    except (ValidationError, TypeError, ValueError):
        return None
    columns = columns_of({name: list(values) for name, values in read.columns.items()}, names)
    return None if columns is None else (read.moment, columns)
