"""An operating map from its plan to its files and its document, with progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from drivegate.containment.backend import Backend
from drivegate.gate.warm_up import compile_missing
from drivegate.output.progress import progress_on, with_rate
from drivegate.studies.map.files import write_figure, write_tables
from drivegate.studies.map.map import OperatingMap, computed
from drivegate.studies.map.plan import MapPlan

_SCHEMA: Final = 1


def made_map(
    plan: MapPlan, workers: int | None, *, csv: Path | None, parquet: Path | None, plot: Path | None
) -> tuple[dict[str, Any], str]:
    """Compute a map and write its files; give its document and its title."""
    compile_missing([plan.drive])
    began = time.monotonic()
    title = _title_of(plan)
    with progress_on(sys.stderr) as display:
        report_progress = with_rate(display, title, plan.axes.points, unit="points")
        made = computed(plan, Backend("local", workers), report_progress)
    seconds = time.monotonic() - began
    write_tables(made, csv, parquet)
    if plot is not None:
        write_figure(made, plot, title)
    written = [str(path) for path in (csv, parquet, plot) if path is not None]
    return _document_of(made, seconds, written), title


def _title_of(plan: MapPlan) -> str:
    """Tell whose map it is."""
    if plan.candidate is not None:
        return f"{plan.candidate.name} on {plan.drive.name}"
    return plan.drive.name if plan.kind == "points" else f"the best of {plan.drive.name}"


def _document_of(made: OperatingMap, seconds: float, files: Sequence[str]) -> dict[str, Any]:
    """Give the ranges of what was computed, and the files that it was written into."""
    plan = made.plan
    finite = np.isfinite(made.numbers)
    ranges = {
        name: {"lowest": float(column[here].min()), "highest": float(column[here].max())}
        for name, column, here in zip(plan.columns, made.numbers.T, finite.T, strict=True)
        if here.any() and name != "certified"
    }
    document: dict[str, Any] = {
        "schema": _SCHEMA,
        "kind": "operating map",
        "of": plan.kind,
        "drive": plan.drive.identity(),
        "candidate": None if plan.candidate is None else plan.candidate.name,
        "axes": {name: list(values) for name, values in zip(plan.axes.names, plan.axes.values, strict=True)},
        "points": plan.axes.points,
        "without_values": int(np.count_nonzero(~finite.any(axis=1))),
        "ranges": ranges,
        "verdicts": {verdict: made.verdicts.count(verdict) for verdict in sorted(set(made.verdicts))},
    }
    if plan.kind == "points":
        document["not_certified"] = int(np.count_nonzero(made.numbers[:, -1] == 0.0))
    return document | {"files": list(files), "timing": {"seconds": seconds}}
