"""An operating map from its plan to its files and its document, with progress."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from drivegate.containment.backend import Backend
from drivegate.gate.warm_up import compile_missing
from drivegate.output.progress import progress_on, with_rate
from drivegate.studies.map.document import document_of, title_of
from drivegate.studies.map.files import write_figure, write_tables
from drivegate.studies.map.map import computed
from drivegate.studies.map.plan import MapPlan


def made_map(
    plan: MapPlan, workers: int | None, *, csv: Path | None, parquet: Path | None, plot: Path | None
) -> tuple[dict[str, Any], str]:
    """Compute a map and write its files; give its document and its title."""
    compile_missing([plan.drive])
    began = time.monotonic()
    title = title_of(plan)
    with progress_on(sys.stderr) as display:
        report_progress = with_rate(display, title, plan.axes.points, unit="points")
        made = computed(plan, Backend("local", workers), report_progress)
    seconds = time.monotonic() - began
    write_tables(made, csv, parquet)
    if plot is not None:
        write_figure(made, plot, title)
    written = [str(path) for path in (csv, parquet, plot) if path is not None]
    return document_of(made, seconds, written), title
