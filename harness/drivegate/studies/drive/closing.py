"""The last lines about a drive: what follows from its data sheet, what a check refuses, and what to do next."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivegate.drives.power_reach import setting_words
from drivegate.output.console import plain

if TYPE_CHECKING:
    from rich.console import Console


def show_closing(console: Console, document: dict[str, Any], advice: str) -> None:
    """Print what follows, what a check refuses, the files, and the next step: `advice` where it refuses nothing."""
    for row in document["following"]:
        value = setting_words({row["key"]: row["value"]})
        console.print(plain(f"from the data sheet: {value} follows from {row['from']}"))
    refused = document["unreachable"]
    for row in refused:
        console.print(plain(f"a check refuses this drive: {row['message']}", "bold red"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    console.print(plain(f"next: {_changes(refused) if refused else advice}", "dim"))


def _changes(refused: list[dict[str, Any]]) -> str:
    """Return the first change that each refusal names, of equal keys the first one."""
    first: dict[str, float] = {}
    for row in refused:
        first = (row["accepted"][0] if row["accepted"] else {}) | first
    if not first:
        return "change the machine, the supply or the rating; no single value of the rating would do"
    extra = ", and closed_loop_ripple_percent above it" if "ripple_percent" in first else ""
    settings = " --set ".join(setting_words({key: value}).replace(" ", "") for key, value in first.items())
    words = ", ".join(setting_words({key: value}) for key, value in first.items())
    return f"write {words}{extra} into the drive's file, or try it with --set {settings}"
