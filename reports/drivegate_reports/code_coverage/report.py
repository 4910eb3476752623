"""The page with a candidate's sources, on which each line and branch that no run reached is marked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from drivegate.output.code_coverage import KIND
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import counted
from drivegate_models.errors import InputError
from drivegate_reports.page.page import clean, page_text

REPORT_FILE: Final = "index.html"
"""Name of the page in its folder."""
_LONGEST_LINE: Final = 400


@dataclass(frozen=True)
class LineView:
    number: int
    count: str
    """How often it ran; empty where there is no code."""
    text: str
    tone: str
    """``pass``, ``caution`` where a branch is open, ``fail`` where it never ran; empty where there is no code."""
    note: str
    """What no run has taken, and what would reach it."""


@dataclass(frozen=True)
class FileView:
    name: str
    summary: str
    lines: tuple[LineView, ...]


def write(document: Mapping[str, Any], folder: Path) -> Path:
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    if document.get("kind") != KIND:
        raise InputError(f"the document is of kind {document.get('kind')!r}, but must be of kind '{KIND}'")
    return page_text(
        "code_coverage.html.j2",
        candidate=clean(document["candidate"], 200),
        facts=(("drive", clean(document["drive"])), ("runs", str(document["runs"]))),
        message=clean(document["message"]),
        files=[_file(file) for file in document["files"]],
    )


def _file(file: Mapping[str, Any]) -> FileView:
    lines = tuple(_line(number, line) for number, line in enumerate(file["lines"], 1))
    never, partly = (sum(line.tone == tone for line in lines) for tone in ("fail", "caution"))
    summary = (
        f"{counted(never, 'line')} never ran; {counted(partly, 'more line')} ran with a branch not taken."
    )
    return FileView(clean(file["name"]), summary, lines)


def _line(number: int, line: Mapping[str, Any]) -> LineView:
    count, branches = line["count"], line["branches"]
    text = clean(line["text"], _LONGEST_LINE)
    if count is None:
        return LineView(number, "", text, "", "")
    open_branches = [place for place, taken in enumerate(branches, 1) if not taken]
    if count == 0:
        return LineView(number, "0", text, "fail", _note("never ran", line["hint"]))
    if not open_branches:
        return LineView(number, str(count), text, "pass", "")
    if len(branches) == 2:
        words = "only one way out of the condition was taken"
    else:
        listed = ", ".join(map(str, open_branches))
        words = f"of {len(branches)} ways out of the condition, these were not taken: {listed}"
    return LineView(number, str(count), text, "caution", _note(words, line["hint"]))


def _note(words: str, hint: str) -> str:
    return clean(f"{words}; what moves it: {hint}" if hint else words)
