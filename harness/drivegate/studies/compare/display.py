"""A comparison on the console."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drivegate.contracts.current.checks.feasible_angles import FEASIBLE
from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console
    from rich.text import Text


def show_comparison(console: Console, document: dict[str, Any], pages: Sequence[Path]) -> None:
    """Print the ranking, what differs for certain, and where the report is."""
    figures = (
        "required failed",
        "points held",
        "W above first",
        "A above first",
        "Σ|i| above best possible (%)",
    )
    listed = table("place", "candidate", *figures, right=("place", *figures))
    for row in document["tables"]["ranking"]:
        listed.add_row(
            *ranked(row),
            *failed_and_held(row, "points_feasible"),
            without_negative_zero(row["power_above_first_w"], 1),
            without_negative_zero(row["current_above_first_a"], 2),
            number(row["gap_current_percent"], 2),
        )
    console.print(listed)
    _show_differences(console, document)
    console.print(plain(f"rule: {document['rule']}"))
    console.print(plain(f"points and the best possible are of feasible angles: {FEASIBLE}"))
    show_faults_and_pages(console, document, pages)


def ranked(row: Mapping[str, Any]) -> tuple[Text, Text]:
    """Write the place of a candidate, or why it has none, and its name."""
    return plain(row["status"] if row["rank"] is None else row["rank"]), plain(row["candidate"])


def failed_and_held(row: Mapping[str, Any], points: str = "points") -> tuple[str, str]:
    """Write how many required checks a candidate fails, and how many operating points it holds of those there are."""
    failed = row["required_failed"]
    return "–" if failed is None else str(failed), f"{row['points_held']} of {row[points]}"


def show_faults_and_pages(console: Console, document: dict[str, Any], pages: Sequence[Path]) -> None:
    """Print what failed, and where the report is."""
    for entry in document["candidates"]:
        for fault in entry["faults"]:
            console.print(plain(f"{entry['label']}: {fault['kind']}: {fault['message']}", "bold red"))
    for page in pages:
        console.print(plain(f"report: {page}"))


def without_negative_zero(value: float | None, digits: int) -> str:
    """Write a number without a negative zero."""
    return number(value if value is None else round(value, digits) + 0.0, digits)


def _show_differences(console: Console, document: dict[str, Any]) -> None:
    rows = [
        row
        for row in document["tables"]["differences"]
        if row["where"].startswith(("drawn", "drive cycle")) and row["mean_difference"] is not None
    ]
    if not rows:
        return
    columns = ("difference", "from", "to")
    listed = table("where", "first less second", *columns, "pairs", "unit", "verdict", right=columns)
    for row in rows:
        listed.add_row(
            plain(row["where"]),
            plain(f"{row['first']} − {row['second']}"),
            *(without_negative_zero(row[key], 2) for key in ("mean_difference", "low", "high")),
            str(row["pairs"]) + (f" (+ {row['left_out']} lost)" if row["left_out"] else ""),
            plain(row["unit"]),
            plain(row["verdict"]),
        )
    console.print(listed)
