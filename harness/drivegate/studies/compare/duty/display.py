"""A comparison of controllers of duty ratios on the console."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console

_COLUMNS: Final = (
    ("loss_above_least_percent", "loss above least (%)", 2),
    ("current_above_least_percent", "current above least (%)", 2),
    ("ripple_worst_percent", "worst ripple (%)", 2),
    ("overshoot_worst_percent", "worst overshoot (%)", 2),
    ("rise_worst_percent_of_allowed", "worst rise of allowed (%)", 0),
)


def show_duty_comparison(console: Console, document: dict[str, Any], pages: Sequence[Path]) -> None:
    """Print the ranking, and where the report is."""
    figures = ("required failed", "points held", *(head for _, head, _ in _COLUMNS))
    listed = table("place", "candidate", *figures, right=("place", *figures))
    for row in document["tables"]["ranking"]:
        failed = row["required_failed"]
        listed.add_row(
            plain(row["status"] if row["rank"] is None else row["rank"]),
            plain(row["candidate"]),
            "–" if failed is None else str(failed),
            f"{row['points_held']} of {row['points']}",
            *(_number(row[key], digits) for key, _, digits in _COLUMNS),
        )
    console.print(listed)
    console.print(plain(f"rule: {document['rule']}"))
    for entry in document["candidates"]:
        for fault in entry["faults"]:
            console.print(plain(f"{entry['label']}: {fault['kind']}: {fault['message']}", "bold red"))
    for page in pages:
        console.print(plain(f"report: {page}"))


def _number(value: float | None, digits: int) -> str:
    """Write a number without a negative zero."""
    return number(value if value is None else round(value, digits) + 0.0, digits)
