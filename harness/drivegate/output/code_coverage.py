"""The page of what runs reached of a candidate's code, which installed packages write."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.reached_code import Line, SourceFile
from drivegate.contracts.catalogue import contract_of
from drivegate.output.code_conditions import Conditions
from drivegate.output.report_writers import CODE_COVERAGE_GROUP, report_points, write_reports
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument

if TYPE_CHECKING:
    from drivegate.results.document import ResultDocument

KIND: Final = "code coverage"


def write_code_pages(result: ResultDocument, files: Sequence[SourceFile], folder: Path) -> None:
    """Have installed packages write their pages into a folder."""
    points = report_points(CODE_COVERAGE_GROUP)
    written = write_reports(
        code_document(result, files), folder, {name: point.load for name, point in points.items()}
    )
    written.require_all()


def code_document(result: ResultDocument, files: Sequence[SourceFile]) -> dict[str, Any]:
    """Write what was reached as plain data, with the sources."""
    assert result.code_coverage is not None, "it was measured"
    assert result.drive is not None, "every check has a drive"
    drive = parse_document(result.drive.document or {}, DriveDocument, "the drive")
    # Signals pass from one file to another.
    conditions = Conditions([line for file in files for line in file.text], contract_of(drive).moved_by)
    return {
        "kind": KIND,
        "candidate": result.candidate.name,
        "drive": result.drive.name,
        "runs": result.runs,
        "message": result.code_coverage.message,
        "files": [_file(file, conditions) for file in files],
    }


def _file(file: SourceFile, conditions: Conditions) -> dict[str, Any]:
    measured = {line.number: line for line in file.lines}
    return {
        "name": file.name,
        "lines": [_line(text, measured.get(number), conditions) for number, text in enumerate(file.text, 1)],
    }


def _line(text: str, line: Line | None, conditions: Conditions) -> dict[str, Any]:
    if line is None:
        return {"text": text, "count": None, "branches": [], "hint": ""}
    is_open = line.count == 0 or not all(line.branches)
    return {
        "text": text,
        "count": line.count,
        "branches": list(line.branches),
        "hint": conditions.hint(text) if is_open and line.branches else "",
    }
