"""What comes along, on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivegate.output.console import plain, table

if TYPE_CHECKING:
    from rich.console import Console


def show_cases(console: Console, document: dict[str, Any]) -> None:
    """Print one table for each kind."""
    for key, heading in (
        ("scenarios", "scenario"),
        ("operating_points", "operating point"),
        ("sweeps", "sweep"),
        ("drive_cycles", "drive cycle"),
        ("drives", "drive"),
    ):
        listed = table(heading, "description")
        for row in document[key]:
            listed.add_row(plain(row["name"]), plain(row["description"]))
        console.print(listed)
    console.print(
        plain(
            "next: drivegate simulate reference --case NAME runs a scenario, --drive NAME takes a drive, "
            "drivegate compare A B --cycle NAME drives a cycle",
            "dim",
        )
    )
