"""A comparison of drives on the console."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from drivegate.output.console import number, plain, table
from drivegate.studies.compare.display import failed_and_held
from drivegate_cases.documents.wording import figure

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console


def show_drive_comparison(console: Console, document: dict[str, Any], pages: Sequence[Path]) -> None:
    """Print the drives side by side for each candidate, what the bases are, and where the report is."""
    figures = (
        "failed",
        "held",
        "shared",
        "efficiency %",
        "losses pu",
        "W",
        "Σ|i| pu",
        "A",
        "ripple %",
        "up to pu",
    )
    listed = table("candidate", "drive", *figures, right=figures)
    for row in document["tables"]["summary"]:
        listed.add_row(
            plain(row["candidate"]),
            plain(row["drive"] if row["status"] == "compared" else f"{row['drive']}: {row['status']}"),
            *failed_and_held(row),
            str(row["points_shared"]),
            number(row["efficiency_percent"], 2),
            number(row["losses_pu"], 4),
            _absolute(row["losses_w"]),
            number(row["current_sum_pu"], 3),
            _absolute(row["current_sum_a"]),
            number(row["ripple_full_load_percent"], 1),
            number(row["rated_power_held_up_to_pu"], 2),
        )
    console.print(listed)
    console.print(plain(document["bases"]))
    console.print(plain(document["losses"]))
    console.print(
        plain(
            "failed: required checks; held: operating points; means are over the shared ones, which a candidate "
            "holds on every drive; ripple: the worst of them at full load; up to: speed up to which it held that; full "
            "load is rated power, or 90 % of it for controllers of duty ratios"
        )
    )
    for row in document["tables"]["drives"]:
        reached = row["constant_power_up_to_pu"]
        told = (
            "rated power nowhere" if reached is None else f"rated power up to {reached:.2f} pu of base speed"
        )
        console.print(plain(f"{row['drive']}: {told}, whatever the controller, within overspeed"))
    _show_faults(console, document)
    for page in pages:
        console.print(plain(f"report: {page}"))


def _absolute(value: float | None) -> str:
    return "–" if value is None else figure(value)


def _show_faults(console: Console, document: dict[str, Any]) -> None:
    for entry, part in zip(document["drives"], document["parts"], strict=True):
        for candidate in part["candidates"]:
            for fault in candidate["faults"]:
                told = f"{candidate['label']} on {entry['label']}: {fault['kind']}: {fault['message']}"
                console.print(plain(told, "bold red"))
