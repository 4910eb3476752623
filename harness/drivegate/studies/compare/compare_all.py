"""Comparing candidates into a folder; what one of them does never stops the others."""

from __future__ import annotations

import csv
import io
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import bounded_line
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.choice import common_drive
from drivegate.drives.reach import refuse_unreachable
from drivegate.output.event_loop import followed
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import COMPARISON_GROUP, report_points, write_reports
from drivegate.output.result_file import as_json

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

COMPARISON_FILE: Final = "comparison.json"
TABLES: Final = "tables"


@dataclass(frozen=True)
class ComparisonOptions:
    """How much is compared, and on what.

    Attributes
    ----------
    effort : str
        ``quick``, ``default`` or ``nightly``.
    seed : int
        Seed of everything drawn.
    workers : int or None
        Number of processes; None for as many as there are processors.
    checks : bool
        Whether the checks are made as well.
    cycle : str
        Name or file of the drive cycle.
    drive : DriveDocument or None
        The drive; None for that of the candidates' manifests, or the default.
    """

    effort: str = "default"
    seed: int = 0
    workers: int | None = None
    checks: bool = True
    cycle: str = "ece-15"
    drive: DriveDocument | None = None


@dataclass(frozen=True)
class ComparisonEnding:
    """What a comparison came to.

    Attributes
    ----------
    document : dict or None
        The comparison document; None where no candidate could be run.
    pages : tuple of Path
        The written reports.
    refused : tuple of tuple
        Specification and error of each candidate that could not be compared.
    """

    document: dict[str, Any] | None
    pages: tuple[Path, ...]
    refused: tuple[tuple[str, Exception], ...]


def compare_all(specifications: Sequence[str], output: Path, options: ComparisonOptions) -> ComparisonEnding:
    """Compare candidates and write the report; nothing is written where none of them could be run."""
    from drivegate_cases.scenario.drive_cycle import load_drive_cycle

    resolved = [_resolved(specification) for specification in specifications]
    candidates = [found for found in resolved if isinstance(found, Candidate)]
    if not candidates:
        return ComparisonEnding(None, (), _errors(specifications, resolved))
    cycle, drive = load_drive_cycle(options.cycle), common_drive(candidates, options.drive)
    refuse_unreachable(drive)
    with ReportFolder(output) as folder:
        document, refused = _compared(specifications, resolved, cycle, drive, options)
        if document is None:
            return ComparisonEnding(None, (), refused)
        write_tables(document, folder.staging)
        (folder.staging / COMPARISON_FILE).write_text(as_json(document), encoding="utf-8")
        writers = {name: point.load for name, point in report_points(COMPARISON_GROUP).items()}
        written = write_reports(document, folder.staging, writers)
        written.require_all()
        folder.commit()
    return ComparisonEnding(document, tuple(output / page for page in written.pages.values()), refused)


def _resolved(specification: str) -> Candidate | Exception:
    try:
        return resolve_candidate(specification)
    except Exception as error:
        return error


def _errors(
    specifications: Sequence[str], resolved: Sequence[Candidate | Exception]
) -> tuple[tuple[str, Exception], ...]:
    return tuple(
        (specification, found)
        for specification, found in zip(specifications, resolved, strict=True)
        if isinstance(found, Exception)
    )


def _compared(
    specifications: Sequence[str],
    resolved: Sequence[Candidate | Exception],
    cycle: Any,
    drive: DriveDocument,
    options: ComparisonOptions,
) -> tuple[dict[str, Any] | None, tuple[tuple[str, Exception], ...]]:
    # These bring the compiled plant, which candidates that are refused do not need.
    from drivegate.studies.compare.document import comparison_document
    from drivegate.studies.compare.engine import labelled, prepared, run_plan, solve_plan
    from drivegate.studies.compare.plan import planned_runs

    started, began = _now(), time.monotonic()
    names = [
        found.name if isinstance(found, Candidate) else bounded_line(specification)[:200]
        for specification, found in zip(specifications, resolved, strict=True)
    ]
    all_compared = labelled(specifications, names)
    oracle: dict[str, Any] = {}
    with progress_on(sys.stderr) as display:
        followed(prepared(), display)
        plan = planned_runs(drive, cycle, options.effort, options.seed)
        for compared, found in zip(all_compared, resolved, strict=True):
            if isinstance(found, Exception):
                compared.error = found
                continue
            compared.candidate = found
            try:
                runs = run_plan(
                    compared, plan, seed=options.seed, workers=options.workers, checks=options.checks
                )
                followed(runs, display)
            except Exception as error:
                compared.error = error
        refused = tuple(
            (compared.specification, compared.error)
            for compared in all_compared
            if compared.error is not None
        )
        if len(refused) == len(all_compared):
            return None, refused
        followed(solve_plan(plan, options.workers, oracle), display)
    document = comparison_document(
        all_compared,
        plan,
        oracle,
        drive=drive,
        cycle=cycle,
        effort=options.effort,
        seed=options.seed,
        checks=options.checks,
        timing={"started_utc": started, "seconds": round(time.monotonic() - began, 3)},
    )
    return document, refused


def _now() -> str:
    """Tell the day, or the one that SOURCE_DATE_EPOCH names."""
    from drivegate.results.waivers import present_day

    return present_day().isoformat()


def write_tables(document: Mapping[str, Any], folder: Path) -> tuple[Path, ...]:
    """Write every table of a comparison as CSV."""
    (folder / TABLES).mkdir(exist_ok=True)
    tables = {**document["tables"], "timing": document["timing"]["steps"]}
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
