"""What a drive can do, from its document to the finished one, with progress."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from drivegate.drives.envelope import envelope, recommended_line, speeds_of
from drivegate.drives.envelope_document import envelope_document
from drivegate.drives.pm_ac_envelope import pm_ac_envelope
from drivegate.drives.rating import rated_drive
from drivegate.drives.reach import Refusal, refusals
from drivegate.output.progress import progress_on, with_rate
from drivegate.studies.drive.figure import write_figure
from drivegate.studies.drive.fit import fit_document
from drivegate.studies.drive.measured import read_measured
from drivegate_cases.documents.wording import counted
from drivegate_cases.drive.data_sheet import following
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument

SCHEMA: Final = 1
"""Version of the document."""


def studied_drive(chosen: DriveDocument, *, plot: Path | None = None) -> dict[str, Any]:
    """Compute what a drive can do, and draw it."""
    if isinstance(chosen, PmAcDocument):
        return _studied_pm_ac(chosen, plot)
    drive = rated_drive(chosen)
    speeds = speeds_of(drive.rating)
    with progress_on(sys.stderr) as display:
        report_progress = with_rate(display, drive.name, len(speeds), unit="speeds")
        refused = refusals(chosen)
        line = recommended_line(drive)
        report_progress(0, 0)
        points = []
        for point in envelope(drive, line, speeds):
            points.append(point)
            report_progress(len(points), 0)
    document = {
        "schema": SCHEMA,
        "kind": "drive",
        "drive": drive.name,
        **_of_its_file(chosen, refused),
        **envelope_document(drive, line, points),
    }
    if plot is not None:
        write_figure(document, plot)
    return document | {"files": [] if plot is None else [str(plot)]}


def _of_its_file(chosen: DriveDocument, refused: Sequence[Refusal]) -> dict[str, Any]:
    """Return what follows from other values of the file, and what a check refuses of it."""
    return {
        "following": [
            {"key": key, "value": chosen.value(key), "from": source}
            for key, source in following(chosen).items()
        ],
        "unreachable": [row.document() for row in refused],
    }


def _studied_pm_ac(chosen: PmAcDocument, plot: Path | None) -> dict[str, Any]:
    document = {
        "schema": SCHEMA,
        "kind": "drive",
        "drive": chosen.name,
        **_of_its_file(chosen, refusals(chosen)),
        **pm_ac_envelope(chosen),
    }
    if plot is not None:
        write_figure(document, plot)
    return document | {"files": [] if plot is None else [str(plot)]}


def fitted_drive(chosen: DriveDocument, measured: Path, kept: Sequence[str]) -> dict[str, Any]:
    """Fit the constants of a drive to the torques in a file."""
    points = read_measured(measured)
    with progress_on(sys.stderr) as display:
        display.begin(chosen.name, 1, f"fitting to {counted(len(points), 'point')}")
        return fit_document(chosen, points, kept)
