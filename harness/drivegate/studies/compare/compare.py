"""Comparing candidates on one or more drives into a folder; what one of them does never stops the others."""

from __future__ import annotations

import csv
import io
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.candidates.fault import bounded_line
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.comparison import ComparisonRequest
from drivegate.drives.abilities import refuse_unreachable
from drivegate.drives.kinds import at_declared_timing, common_drive
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import (
    COMPARISON_GROUP,
    DRIVE_COMPARISON_GROUP,
    WrittenReports,
    report_points,
    write_reports,
)
from drivegate.output.result_file import as_json
from drivegate.studies.compare.compared_drive import DEFAULT_CYCLE, ComparisonOptions
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.studies.compare.compared_drive import ComparedDrive
    from drivegate_cases.drive.drive_document import DriveDocument

COMPARISON_FILE: Final = "comparison.json"
DRIVE_COMPARISON_FILE: Final = "drive-comparison.json"
TABLES: Final = "tables"
_SHOWN_OF_HASH: Final = 8

Refused: TypeAlias = tuple[tuple[str, Exception], ...]
"""Specification and error of each candidate that could not be compared."""


@dataclass(frozen=True)
class ComparisonEnding:
    """The outcome of a comparison."""

    document: dict[str, Any] | None
    """The document; None where on some drive no candidate could be run."""
    pages: tuple[Path, ...]
    """The written reports."""
    refused: Refused
    """Specification and error of each candidate that could not be compared."""


def compare(
    specifications: Sequence[str], drives: Sequence[DriveDocument], output: Path, options: ComparisonOptions
) -> ComparisonEnding:
    """Compare candidates and write the reports; nothing is written where on some drive none of them could be run.

    Without a drive, it is the candidates' own. With several, each is compared as if it were the only one, and then
    all side by side.
    """
    from drivegate_cases.scenario.drive_cycle import load_drive_cycle

    labels = drive_labels(drives)
    _require_one_contract(drives)
    resolved = [_resolved(specification) for specification in specifications]
    candidates = [found for found in resolved if isinstance(found, Candidate)]
    if not candidates:
        return ComparisonEnding(None, (), _refused(specifications, resolved, labels, ()))
    if len(drives) < 2:
        drives, labels = [common_drive(candidates, *drives)], ("",)
    else:
        drives = [at_declared_timing(drive, candidates) for drive in drives]
    for drive in drives:
        options.refuse_unused(drive)
    cycle = load_drive_cycle(options.cycle or DEFAULT_CYCLE)
    requests = [ComparisonRequest(drive, options.effort, options.seed, cycle) for drive in drives]
    with ReportFolder(output) as folder:
        document, made = _compared(specifications, resolved, requests, labels, options)
        refused = _refused(specifications, resolved, labels, made)
        if document is None:
            return ComparisonEnding(None, (), refused)
        written = write_comparison(document, folder.staging)
        # The numbers are kept, whatever becomes of the pages.
        folder.commit()
        written.require_all()
    return ComparisonEnding(document, tuple(output / page for page in written.pages.values()), refused)


def _compared(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    requests: Sequence[ComparisonRequest],
    labels: Sequence[str],
    options: ComparisonOptions,
) -> tuple[dict[str, Any] | None, Sequence[ComparedDrive]]:
    """Compare candidates on every drive; the document is that of the one drive, or of all of them."""
    # It brings what candidates that are refused do not need.
    from drivegate.output.event_loop import followed
    from drivegate.results.waivers import present_day
    from drivegate.studies.compare.compared_drive import compared_on
    from drivegate.studies.compare.drive_comparison import drive_comparison_document
    from drivegate.studies.compare.engine import prepared

    began, made = time.monotonic(), []
    with progress_on(sys.stderr) as display:
        display.begin("comparison")
        for request in requests:
            followed(prepared(request.drive), display)
            # Not sooner: it needs most of the kernels, which this process would compile alone.
            refuse_unreachable(request.drive)
        for label, request in zip(labels, requests, strict=True):
            place = f" on {label}" if label else ""
            made.append(compared_on(specifications, resolved, request, options, display, place=place))
            if made[-1].document is None:
                return None, made
    if len(made) == 1:
        return made[0].document, made
    timing = {"started_utc": present_day().isoformat(), "seconds": round(time.monotonic() - began, 3)}
    return drive_comparison_document(labels, made, timing=timing), made


def drive_labels(drives: Sequence[DriveDocument]) -> tuple[str, ...]:
    """Label every drive by its name, and by its hash where another has the same name."""
    names = [drive.name for drive in drives]
    for place, drive in enumerate(drives):
        same = next((other for other in drives[:place] if other.values_hash == drive.values_hash), None)
        if same is not None:
            raise InputError(
                f"the drives '{same.name}' and '{drive.name}' have the same values, so there is nothing to compare "
                "between them; name each drive once"
            )
    return tuple(
        drive.name if names.count(drive.name) == 1 else f"{drive.name} ({drive.values_hash[:_SHOWN_OF_HASH]})"
        for drive in drives
    )


def _resolved(specification: str) -> Candidate | Exception:
    """Find a candidate, or why there is none."""
    try:
        return resolve_candidate(specification)
    except Exception as error:
        return error


def _require_one_contract(drives: Sequence[DriveDocument]) -> None:
    """Refuse drives that no one controller runs on."""
    for first, other in pairwise(drives):
        if other.contract != first.contract:
            raise InputError(
                f"the drive '{one_line(first.name)}' takes {ANSWERS[first.contract]}, but '{one_line(other.name)}' "
                f"takes {ANSWERS[other.contract]}, so no one controller runs on both; name drives of one contract, or "
                "see drivegate reproduce for kinds of drives at the best that each can do"
            )


def _refused(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    labels: Sequence[str],
    made: Sequence[ComparedDrive],
) -> Refused:
    """List who was refused, once where it has nothing to do with a drive."""
    unknown = [
        (specification, found)
        for specification, found in zip(specifications, resolved, strict=True)
        if isinstance(found, Exception)
    ]
    return (
        *unknown,
        *(
            (f"{compared.specification} on {label}" if label else compared.specification, compared.error)
            for label, one in zip(labels, made, strict=False)
            for compared in one.all_compared
            if compared.error is not None and compared.error not in resolved
        ),
    )


def write_comparison(document: dict[str, Any], folder: Path) -> WrittenReports:
    """Write all files of a comparison; each drive has its own folder. The pages are those of the whole."""
    errors: dict[str, Exception] = {}
    parts = zip(document.get("drives", ()), document.get("parts", ()), strict=True)
    for entry, part in parts:
        own = folder / entry["folder"]
        own.mkdir()
        errors |= write_comparison(part, own).errors
    write_tables(document, folder)
    file, group = (
        (DRIVE_COMPARISON_FILE, DRIVE_COMPARISON_GROUP)
        if "parts" in document
        else (COMPARISON_FILE, COMPARISON_GROUP)
    )
    (folder / file).write_text(as_json(document), encoding="utf-8")
    written = write_reports(
        document, folder, {name: point.load for name, point in report_points(group).items()}
    )
    return WrittenReports(written.pages, errors | dict(written.errors))


def write_tables(document: Mapping[str, Any], folder: Path) -> None:
    """Write every table of a comparison as CSV."""
    (folder / TABLES).mkdir(exist_ok=True)
    steps = document["timing"].get("steps")
    tables = {**document["tables"], **({} if steps is None else {"timing": steps})}
    for name, rows in tables.items():
        (folder / TABLES / f"{name}.csv").write_text(table_text(rows), encoding="utf-8", newline="")


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
