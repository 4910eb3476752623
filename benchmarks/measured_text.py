"""What benchmarks write into pages: text between two marks, which nobody writes by hand."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from drivegate_cases.documents.atomic_write import write_atomically

SEARCHING: Final = Path(__file__).resolve().parent.parent / "docs" / "searching.md"
"""The page on what a search is worth."""


def write_measured(page: Path, name: str, text: str) -> None:
    """Replace the text between the marks of a name in a page, which must have them once."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    renewed, count = re.subn(
        f"{re.escape(begin)}.*?{re.escape(end)}",
        lambda _: f"{begin}\n\n{text}\n\n{end}",
        page.read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    if count != 1:
        raise SystemExit(f"{page}: has no place '{begin}'")
    write_atomically(page, renewed)
