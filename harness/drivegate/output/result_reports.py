"""The one way out of a result document: its files, and every format that is requested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path, PurePath
from typing import Any, Final

from drivegate.output.continuous_integration import write_junit, write_markdown
from drivegate.output.explanations import by_urgency, distinct_faults, explanations, in_runs
from drivegate.output.report_writers import (
    LoadWriter,
    WriteReport,
    WrittenReports,
    report_points,
    write_reports,
)
from drivegate.output.rerun import moved_to
from drivegate.output.result_file import write_result_files
from drivegate.output.run_list import write_runs
from drivegate.output.streams import harmless
from drivegate.results.result import NOT_WITNESSED, STALE_WAIVERS, alteration_of, counted_levels
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import HarnessFault, InputError

_ANNOTATIONS_FILE: Final = "annotations.txt"

_LEVELS: Final = ("error", "warning", "notice")
_PLACES: Final = 10
"""Annotations of one level that GitHub shows of a step."""
_OPEN: Final = "inconclusive"

_Line = tuple[str, str, str]
"""Level, title and message of an annotation."""

_IN_MESSAGE: Final = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_IN_TITLE: Final = _IN_MESSAGE | str.maketrans({":": "%3A", ",": "%2C"})


def _write_annotations(result: dict[str, Any], folder: Path) -> Path:
    path = folder / _ANNOTATIONS_FILE
    path.write_text("".join(f"{line}\n" for line in workflow_commands(result)), encoding="utf-8")
    return path


def workflow_commands(result: dict[str, Any]) -> list[str]:
    """Return one command for each fault and for each check that is not simply met, at the candidate's file.

    GitHub shows a few of each level: what failed comes first, and one line sums up what was not judged.
    """
    name, file = result["candidate"]["name"], _candidate_file(result["candidate"]["specification"])
    counted = counted_levels(result.get("fail_on"))
    first, *others = [
        [("error", f"{fault['kind']}{in_runs(count)}", fault["message"])]
        for fault, count in distinct_faults(result["faults"])
    ] or [[]]
    explained = explanations(result)
    judged: list[_Line] = []
    open_ones: list[_Line] = []
    for check in by_urgency(list(result["checks"])):
        level = _level(check, counted)
        message = "; ".join(filter(None, (explained.get(check["id"]), check["message"])))
        if level:
            listed = open_ones if check["verdict"] == _OPEN else judged
            listed.append((level, f"{check['id']} {check['verdict']}", message))
    against = [
        ("error", f"{entry['check']} against the baseline", entry["message"])
        for entry in result["baseline"] or ()
        if entry["level"] in counted and entry["verdict"] == "fail"
    ]
    altered = alteration_of(result)
    unverified = [("error", "content hash", f"the result {altered}")] if altered else []
    lines = [*unverified, *first, *judged, *against, *chain(*others)]
    return [
        _command(level, file, f"{name} {title}", message)
        for one_level in _LEVELS
        for level, title, message in _in_few_places(
            [line for line in lines if line[0] == one_level],
            [line for line in open_ones if line[0] == one_level],
        )
    ]


def _in_few_places(lines: list[_Line], open_ones: list[_Line]) -> list[_Line]:
    """Sum up in one line each what was not judged, and what has no place."""
    if len(open_ones) > 1:
        names = [title.split()[0] for _, title, _ in open_ones]
        level, _, reason = open_ones[0]
        message = f"{', '.join(names)}; {names[0]}: {reason}"
        open_ones = [(level, f"{len(names)} checks {_OPEN}", message)]
    most = _PLACES - len(open_ones)
    if len(lines) > most:
        left = lines[most - 1 :]
        summed = (left[0][0], f"{len(left)} more", "; ".join(title for _, title, _ in left))
        lines = [*lines[: most - 1], summed]
    return [*lines, *open_ones]


def _level(check: dict[str, Any], counted: tuple[str, ...]) -> str:
    """State how serious a check's outcome is; empty where there is nothing to report."""
    verdict = check["verdict"]
    if verdict in ("pass", "not applicable"):
        return ""
    uncounted = ("contested", NOT_WITNESSED, "waived")
    if verdict in STALE_WAIVERS or (check["level"] in counted and verdict not in uncounted):
        return "error"
    return "notice" if verdict == "waived" else "warning"


def _candidate_file(specification: str) -> str:
    """Return the file of a candidate as it was named; empty for one without a file in the folder of the job."""
    file = PurePath(specification.partition(":")[0])
    return "" if file.is_absolute() or not file.suffix else file.as_posix()


def _command(level: str, file: str, title: str, message: str) -> str:
    file, title, message = (harmless(one_line(text)) for text in (file, title, message))
    place = f"file={file.translate(_IN_TITLE)}," * bool(file)
    return f"::{level} {place}title={title.translate(_IN_TITLE)}::{message.translate(_IN_MESSAGE)}"


OWN_FORMATS: Final[Mapping[str, WriteReport]] = {
    "annotations": _write_annotations,
    "junit": write_junit,
    "markdown": write_markdown,
    "runs": write_runs,
}
"""Reports for CI servers, which the harness makes itself."""


def write_result(result: dict[str, Any], folder: Path, formats: Mapping[str, LoadWriter]) -> WrittenReports:
    """Write a result, its counterexamples and reports into a folder."""
    write_result_files(result, folder)
    return write_reports(result, folder, formats)


def write_reports_again(
    result: dict[str, Any],
    path: Path,
    folder: Path,
    formats: Mapping[str, LoadWriter],
    place: Path | None = None,
) -> WrittenReports:
    """Write the reports of a result that was read from a file, which somebody may have altered.

    The folder is moved to `place` when it is complete, by default it stays.
    """
    try:
        write_result_files(result, folder)
        written = write_reports(moved_to(result, path, place or folder), folder, formats)
        written.require_all("made")
    except (HarnessFault, LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        if not alteration_of(result):
            raise
        raise InputError(
            f"{shown_path(path)} was altered after drivegate wrote it, and no report can be made from it now: "
            f"{one_line(str(error))}; name an unaltered result"
        ) from error
    return written


def all_formats() -> dict[str, LoadWriter]:
    """Find all reports: first the harness's own, then those of installed packages."""
    return own_formats() | page_formats()


def own_formats() -> dict[str, LoadWriter]:
    """Return the harness's own reports, which are written in no time."""
    return {name: _same(write) for name, write in OWN_FORMATS.items()}


def page_formats() -> dict[str, LoadWriter]:
    return {name: point.load for name, point in report_points().items()}


def report_formats(names: Sequence[str]) -> dict[str, LoadWriter]:
    known = all_formats()
    for name in names:
        if name not in known:
            raise InputError(
                f"there is no report '{one_line(name)}', the nearest is '{nearest(name, known)}'; there are "
                f"{', '.join(sorted(known))}"
            )
    return {name: known[name] for name in (dict.fromkeys(names) if names else sorted(known))}


def _same(write: WriteReport) -> LoadWriter:
    return lambda: write


def read_result(path: Path) -> dict[str, Any]:
    # Typed documents take a while to import, and writing needs none.
    from drivegate.results.stored import read_stored

    mapping = read_stored(path)
    check_result(mapping, path)
    return mapping


def check_result(mapping: dict[str, Any], path: Path) -> None:
    """Refuse a result whose keys are not those of the schema."""
    from drivegate.results.document import ResultDocument
    from drivegate_cases.documents.document import parse_document

    parse_document(mapping, ResultDocument, str(path), folder=path.parent)
