"""The signals of a run as the script of the page takes them, which lets people zoom and read them off."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from drivegate.checks.moment import Moment
from drivegate.contracts.contract import Columns, RecordedTrace
from drivegate.contracts.panels import TIME, Panel, panels_for


def trace_data(
    trace: RecordedTrace, closeup: tuple[Moment, Columns] | None, panels: tuple[Panel, ...]
) -> str:
    """Return a run as JSON, at full resolution where it has a close-up; names are those of the contract alone."""
    columns = trace.columns if closeup is None else _merged(trace.columns, closeup[1])
    start, end = trace.judged_s
    shown: dict[str, Any] = {
        "panels": [
            {"label": label, "lines": [line._asdict() for line in lines]}
            for label, lines in panels_for(panels, columns)
        ],
        "columns": {name: values.tolist() for name, values in columns.items()},
        "start": start,
        "end": end,
        # Words of a document are for the page's own text; here are numbers, and a column that is known.
        "column": closeup[0].column if closeup is not None and closeup[0].column in columns else "",
        "levels": [] if closeup is None else [level.value for level in closeup[0].levels],
    }
    return json.dumps(shown, separators=(",", ":"), allow_nan=False)


def _merged(whole: Columns, near: Columns) -> Columns:
    """Put the rows of a close-up in the place of the means that it replaces."""
    time, first, last = whole[TIME], near[TIME][0], near[TIME][-1]
    before, after = time < first, time > last
    return {
        name: np.concatenate([values[before], near[name], values[after]])
        for name, values in whole.items()
        if name in near
    }
