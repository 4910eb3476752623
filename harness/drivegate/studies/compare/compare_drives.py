"""Comparing candidates on several drives: each drive as if it were the only one, then all side by side."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.drives.reach import refuse_unreachable
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import DRIVE_COMPARISON_GROUP
from drivegate.studies.compare.compare_all import (
    ComparisonEnding,
    compared_in_its_way,
    refusals,
    resolved_candidate,
    write_comparison,
    write_pages,
    write_tables,
)
from drivegate.studies.compare.options import DEFAULT_CYCLE, ComparisonOptions
from drivegate.studies.compare.per_unit import drive_labels
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.studies.compare.compared_drive import ComparedDrive
    from drivegate_cases.drive.drive_document import DriveDocument

DRIVE_COMPARISON_FILE: Final = "drive-comparison.json"


def compare_drives(
    specifications: Sequence[str],
    drives: Sequence[DriveDocument],
    output: Path,
    options: ComparisonOptions,
) -> ComparisonEnding:
    """Compare candidates on each drive and write the reports; nothing where on some drive none could be run."""
    from drivegate_cases.scenario.drive_cycle import load_drive_cycle

    labels = drive_labels(drives)
    _require_one_contract(drives)
    resolved = [resolved_candidate(specification) for specification in specifications]
    unknown = refusals(specifications, resolved)
    if len(unknown) == len(resolved):
        return ComparisonEnding(None, (), unknown)
    for drive in drives:
        options.refuse_unused(drive)
    cycle = load_drive_cycle(options.cycle or DEFAULT_CYCLE)
    for drive in drives:
        refuse_unreachable(drive)
    with ReportFolder(output) as folder:
        began, made = time.monotonic(), []
        with progress_on(sys.stderr) as display:
            for label, drive in zip(labels, drives, strict=True):
                place = f" on {label}"
                made.append(
                    compared_in_its_way(specifications, resolved, cycle, drive, options, display, place=place)
                )
                if made[-1].document is None:
                    return ComparisonEnding(None, (), _refused(labels, made, resolved))
        document = _document(labels, made, options, time.monotonic() - began)
        pages = write_drive_comparison(document, folder.staging)
        folder.commit()
    return ComparisonEnding(
        document, tuple(output / page for page in pages), _refused(labels, made, resolved)
    )


def _require_one_contract(drives: Sequence[DriveDocument]) -> None:
    """Refuse drives that no one controller runs on."""
    first = drives[0]
    other = next((drive for drive in drives if drive.contract != first.contract), None)
    if other is not None:
        raise InputError(
            f"the drive '{one_line(first.name)}' takes {ANSWERS[first.contract]}, but '{one_line(other.name)}' takes "
            f"{ANSWERS[other.contract]}, so no one controller runs on both; name drives of one contract, or see "
            "drivegate reproduce for kinds of drives at the best that each can do"
        )


def _refused(
    labels: Sequence[str], made: Sequence[ComparedDrive], resolved: Sequence[Candidate | Exception]
) -> tuple[tuple[str, Exception], ...]:
    """List who was refused, once where it has nothing to do with a drive."""
    unknown = [found for found in resolved if isinstance(found, Exception)]
    everywhere = [(name, error) for name, error in made[0].refused if error in unknown]
    return tuple(everywhere) + tuple(
        (f"{name} on {label}", error)
        for label, one in zip(labels, made, strict=False)
        for name, error in one.refused
        if error not in unknown
    )


def _document(
    labels: Sequence[str], made: Sequence[ComparedDrive], options: ComparisonOptions, seconds: float
) -> dict[str, Any]:
    from drivegate.results.waivers import present_day
    from drivegate.studies.compare.drive_comparison import drive_comparison_document

    timing = {"started_utc": present_day().isoformat(), "seconds": round(seconds, 3)}
    return drive_comparison_document(labels, made, effort=options.effort, seed=options.seed, timing=timing)


def write_drive_comparison(document: dict[str, Any], folder: Path) -> tuple[Path, ...]:
    """Write the report of the drives, and that of each drive into a folder of its own."""
    for entry, part in zip(document["drives"], document["parts"], strict=True):
        own = folder / entry["folder"]
        own.mkdir()
        write_comparison(part, own)
    write_tables(document, folder)
    return write_pages(document, folder, DRIVE_COMPARISON_FILE, DRIVE_COMPARISON_GROUP)
