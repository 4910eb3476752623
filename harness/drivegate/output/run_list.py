"""The list of all runs as CSV: what a reviewer can make again, run by run."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from drivegate_cases.documents.wording import one_line

RUNS_FILE: Final = "runs.csv"


def runs_csv(result: Mapping[str, Any]) -> str:
    """List the runs of a result: name, seed and hash of the scenario, the least margin, and that of each check."""
    runs = result.get("run_list") or ()
    checks = [check["id"] for check in result["checks"] if any(check["id"] in run["margins"] for run in runs)]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["run", "scenario", "seed", "scenario_hash", "least_check", "least_margin", *checks])
    for number, run in enumerate(runs, start=1):
        margins = run["margins"]
        known = [check for check in checks if margins.get(check) is not None]
        least = min(known, key=lambda check: margins[check], default="")
        lowest = margins[least] if least else ""
        values = (margins.get(check, "") for check in checks)
        writer.writerow([number, one_line(run["name"]), run["seed"], run["hash"], least, lowest, *values])
    return stream.getvalue()


def write_runs(result: dict[str, Any], folder: Path) -> Path:
    path = folder / RUNS_FILE
    path.write_text(runs_csv(result), encoding="utf-8")
    return path
