"""Making the reports of a result that was kept as a file."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.fault import bounded_line
from drivegate.output.junit import JUNIT_FILE, junit_xml
from drivegate.output.markdown import SUMMARY_FILE, markdown
from drivegate.output.report_writers import WriteReport, report_points
from drivegate.output.result_file import RESULT_FILE, as_json, counterexample_name, counterexamples
from drivegate.results.counterexample import require_kind
from drivegate.results.document import ResultDocument
from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import HarnessFault, InputError


def _write_junit(result: dict[str, Any], folder: Path) -> Path:
    (folder / JUNIT_FILE).write_bytes(junit_xml(result))
    return folder / JUNIT_FILE


def _write_markdown(result: dict[str, Any], folder: Path) -> Path:
    (folder / SUMMARY_FILE).write_text(markdown(result), encoding="utf-8")
    return folder / SUMMARY_FILE


OWN_FORMATS: Final[Mapping[str, WriteReport]] = {"junit": _write_junit, "markdown": _write_markdown}
"""Reports for CI servers, which the harness makes itself."""


def report_formats(names: Sequence[str]) -> dict[str, Callable[[], WriteReport]]:
    """Find reports by their names."""
    known: dict[str, Callable[[], WriteReport]] = {name: _same(write) for name, write in OWN_FORMATS.items()}
    known |= {name: point.load for name, point in report_points().items()}
    for name in names:
        if name not in known:
            raise InputError(
                f"there is no report '{one_line(name)}', the nearest is '{nearest(name, known)}'; there are "
                f"{', '.join(sorted(known))}"
            )
    return {name: known[name] for name in (dict.fromkeys(names) if names else sorted(known))}


def _same(write: WriteReport) -> Callable[[], WriteReport]:
    return lambda: write


def read_result(path: Path) -> dict[str, Any]:
    """Read the result of a check."""
    mapping = read_mapping(path)
    if mapping.get("kind") == "checks":
        raise InputError(
            f"{shown_path(path)} holds the results of several candidates; name the result.json of one of them"
        )
    require_kind(mapping, "check", path)
    parse_document(mapping, ResultDocument, str(path), folder=path.parent)
    return dict(mapping)


def write_reports(
    result: dict[str, Any], folder: Path, formats: Mapping[str, Callable[[], WriteReport]]
) -> tuple[Path, ...]:
    """Write a result, its counterexamples and reports into a folder."""
    (folder / RESULT_FILE).write_text(as_json(result), encoding="utf-8")
    for document in counterexamples(result):
        path = folder / counterexample_name(document["check"])
        path.parent.mkdir(exist_ok=True)
        path.write_text(as_json(document), encoding="utf-8")
    pages = []
    for name, load in formats.items():
        try:
            # Standard output belongs to the command.
            with redirect_stdout(sys.stderr):
                page = Path(load()(result, folder))
            pages.append(page.resolve().relative_to(folder.resolve()))
        except Exception as error:
            reason = bounded_line(f"{type(error).__name__}: {error}")
            raise HarnessFault(f"the report '{one_line(name)}' could not be made ({reason})") from error
    return tuple(pages)
