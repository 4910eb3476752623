"""A comparison of controllers of duty ratios on the console."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import plain, table
from drivegate.studies.compare.display import (
    failed_and_held,
    ranked,
    show_faults_and_pages,
    without_negative_zero,
)

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
        listed.add_row(
            *ranked(row),
            *failed_and_held(row),
            *(without_negative_zero(row[key], digits) for key, _, digits in _COLUMNS),
        )
    console.print(listed)
    console.print(plain(f"rule: {document['rule']}"))
    show_faults_and_pages(console, document, pages)
