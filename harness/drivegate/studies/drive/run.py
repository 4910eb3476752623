"""What a drive can do, from its document to the finished one, with progress."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from drivegate.drives.abilities import ability_of, refusals
from drivegate.drives.sheet_values import doubtful_values, sheet_values
from drivegate.output.progress import progress_on, with_rate
from drivegate.studies.drive.figure import write_figure
from drivegate.studies.drive.fit import fit_document, read_measured
from drivegate_cases.documents.wording import counted
from drivegate_cases.drive.data_sheet import following
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.usual_values import unusual_keys

SCHEMA: Final = 1


def studied_drive(chosen: DriveDocument, *, plot: Path | None = None) -> dict[str, Any]:
    ability = ability_of(chosen)
    with progress_on(sys.stderr) as display:
        report_progress = with_rate(display, chosen.name, len(ability.speeds(chosen)), unit="speeds")
        refused = refusals(chosen)
        report_progress(0, 0)
        envelope = ability.envelope(chosen, lambda done: report_progress(done, 0))
    document = {
        "schema": SCHEMA,
        "kind": "drive",
        "drive": chosen.name,
        "following": [
            {"key": key, "value": chosen.value(key), "from": source}
            for key, source in following(chosen).items()
        ],
        "data_sheet": sheet_values(chosen),
        "doubts": list(_doubts(chosen, is_refused=bool(refused))),
        "suspects": unusual_keys(chosen),
        "unreachable": [row.document() for row in refused],
        **envelope,
    }
    if plot is not None:
        write_figure(document, plot)
    return document | {"files": [] if plot is None else [str(plot)]}


def _doubts(chosen: DriveDocument, *, is_refused: bool) -> tuple[str, ...]:
    def accepts(other: DriveDocument) -> bool:
        return not refusals(other)

    return doubtful_values(chosen, is_refused=is_refused, accepts=accepts)


def fitted_drive(chosen: DriveDocument, measured: Path, kept: Sequence[str]) -> dict[str, Any]:
    points = read_measured(measured)
    with progress_on(sys.stderr) as display:
        display.begin(chosen.name, 1, f"fitting to {counted(len(points), 'point')}")
        return fit_document(chosen, points, kept)
