"""Comparing candidates into a folder; what one of them does never stops the others."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import bounded_line
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.choice import common_drive
from drivegate.drives.reach import refuse_unreachable
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import COMPARISON_GROUP, report_points, write_reports
from drivegate.output.result_file import as_json
from drivegate.studies.compare.options import DEFAULT_CYCLE, ComparisonOptions
from drivegate_cases.drive.pm_ac.document import PmAcDocument

if TYPE_CHECKING:
    from drivegate.output.progress import Display
    from drivegate.studies.compare.compared_drive import ComparedDrive
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.drive_cycle import DriveCycle

COMPARISON_FILE: Final = "comparison.json"
TABLES: Final = "tables"


@dataclass(frozen=True)
class ComparisonEnding:
    """What a comparison came to."""

    document: dict[str, Any] | None
    """The comparison document; None where no candidate could be run."""
    pages: tuple[Path, ...]
    """The written reports."""
    refused: tuple[tuple[str, Exception], ...]
    """Specification and error of each candidate that could not be compared."""


def compare_all(specifications: Sequence[str], output: Path, options: ComparisonOptions) -> ComparisonEnding:
    """Compare candidates and write the report; nothing is written where none of them could be run."""
    from drivegate_cases.scenario.drive_cycle import load_drive_cycle

    resolved = [resolved_candidate(specification) for specification in specifications]
    candidates = [found for found in resolved if isinstance(found, Candidate)]
    if not candidates:
        return ComparisonEnding(None, (), refusals(specifications, resolved))
    drive = common_drive(candidates, options.drive)
    options.refuse_unused(drive)
    cycle = load_drive_cycle(options.cycle or DEFAULT_CYCLE)
    refuse_unreachable(drive)
    with ReportFolder(output) as folder:
        with progress_on(sys.stderr) as display:
            made = compared_in_its_way(specifications, resolved, cycle, drive, options, display)
        if made.document is None:
            return ComparisonEnding(None, (), made.refused)
        pages = write_comparison(made.document, folder.staging)
        folder.commit()
    return ComparisonEnding(made.document, tuple(output / page for page in pages), made.refused)


def compared_in_its_way(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    cycle: DriveCycle,
    drive: DriveDocument,
    options: ComparisonOptions,
    display: Display,
    *,
    place: str = "",
) -> ComparedDrive:
    """Compare candidates on a drive in the way of its contract; `place` is added to the titles of the progress."""
    # Either brings its compiled plant, which candidates that are refused do not need.
    if isinstance(drive, PmAcDocument):
        from drivegate.studies.compare.duty.compared import duty_compared_on

        return duty_compared_on(specifications, resolved, drive, options, display, place=place)
    from drivegate.studies.compare.compared_drive import compared_on

    return compared_on(specifications, resolved, cycle, drive, options, display, place=place)


def write_comparison(document: dict[str, Any], folder: Path) -> tuple[Path, ...]:
    """Write all files of a comparison on one drive, and give its pages, relative to the folder."""
    write_tables(document, folder)
    return write_pages(document, folder, COMPARISON_FILE, COMPARISON_GROUP)


def write_pages(document: dict[str, Any], folder: Path, file: str, group: str) -> tuple[Path, ...]:
    """Write a document and all pages that are made of it, and give these, relative to the folder."""
    (folder / file).write_text(as_json(document), encoding="utf-8")
    writers = {name: point.load for name, point in report_points(group).items()}
    written = write_reports(document, folder, writers)
    written.require_all()
    return tuple(written.pages.values())


def resolved_candidate(specification: str) -> Candidate | Exception:
    """Find a candidate, or why there is none."""
    try:
        return resolve_candidate(specification)
    except Exception as error:
        return error


def refusals(
    specifications: Sequence[str], resolved: Sequence[Candidate | Exception]
) -> tuple[tuple[str, Exception], ...]:
    """List the candidates that there are none of, with the reasons."""
    return tuple(
        (specification, found)
        for specification, found in zip(specifications, resolved, strict=True)
        if isinstance(found, Exception)
    )


def write_tables(document: Mapping[str, Any], folder: Path) -> tuple[Path, ...]:
    """Write every table of a comparison as CSV."""
    (folder / TABLES).mkdir(exist_ok=True)
    steps = document["timing"].get("steps")
    tables = {**document["tables"], **({} if steps is None else {"timing": steps})}
    paths = []
    for name, rows in tables.items():
        path = folder / TABLES / f"{name}.csv"
        path.write_text(table_text(rows), encoding="utf-8", newline="")
        paths.append(path)
    return tuple(paths)


def table_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Write rows as CSV."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(row.get(column)) for column in columns] for row in rows)
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        text = bounded_line(value)
        return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text
    return "" if value is None else value
