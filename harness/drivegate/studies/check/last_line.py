"""The last line of a check: verdict, time and report, whatever stands above it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.output.console import plain, verdict_text
from drivegate.results.wording import runs_in_short

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

    from drivegate.studies.check.checked import Checked


def show_last_line(console: Console, all_checked: Sequence[Checked], output: Path) -> None:
    """Print what has become of all candidates on one line."""
    line = plain("")
    for number, checked in enumerate(all_checked):
        line.append("; " if number else "")
        line.append_text(_ending(checked, alone=len(all_checked) == 1))
    seconds = sum(
        checked.document["timing"].get("seconds", 0.0) for checked in all_checked if checked.document
    )
    line.append_text(plain(f", {seconds:.0f} s, report: {_report(all_checked, output)}"))
    console.print(line)


def _ending(checked: Checked, *, alone: bool) -> Text:
    if checked.document is None:
        ending = plain(f"{checked.specification}: ")
        ending.append_text(plain("refused" if checked.exit_code == 2 else "no result", "bold red"))
        return ending
    ending = plain(f"{checked.document['candidate']['name']}: ")
    ending.append_text(verdict_text(checked.document["verdict"]))
    if alone:
        ending.append_text(plain(f", {runs_in_short(checked.document)}"))
    return ending


def _report(all_checked: Sequence[Checked], output: Path) -> Path | str:
    if all(checked.folder is None for checked in all_checked):
        return "none"
    pages = all_checked[0].pages
    return pages[0] if len(all_checked) == 1 and pages else output
