"""What benchmarks write into pages: text between two marks, which nobody writes by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from drivegate_cases.documents.atomic_write import write_atomically

SEARCHING: Final = Path(__file__).resolve().parent.parent / "docs" / "searching.md"
"""The page on what a search is worth."""


def write_measured(page: Path, name: str, text: str) -> None:
    """Replace the text between the marks of a name in a page."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    before, rest = page.read_text(encoding="utf-8").split(begin)
    after = rest.split(end)[1]
    write_atomically(page, f"{before}{begin}\n\n{text}\n\n{end}{after}")
