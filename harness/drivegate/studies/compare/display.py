"""A comparison, on one drive or several, on the console."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.catalogue import comparison_of
from drivegate.contracts.comparison import Figure, Row
from drivegate.output.console import number, plain, table
from drivegate_cases.documents.wording import figure

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console

_SUMMARY: Final = (
    Figure("points_shared", "shared", digits=0),
    Figure("efficiency_percent", "efficiency %"),
    Figure("losses_pu", "losses pu", digits=4),
    Figure("losses_w", "W", digits=None),
    Figure("current_sum_pu", "Σ|i| pu", digits=3),
    Figure("current_sum_a", "A", digits=None),
    Figure("ripple_full_load_percent", "ripple %", digits=1),
    Figure("rated_power_held_up_to_pu", "up to pu"),
)
_SUMMARY_REMARK: Final = (
    "failed: required checks; held: operating points; means are over the shared ones, which a candidate holds on every "
    "drive; ripple: the worst of them at full load; up to: speed up to which it held that; full load is rated power, "
    "or 90 % of it for controllers of duty ratios"
)


def show_comparison(console: Console, document: dict[str, Any], pages: Sequence[Path]) -> None:
    """Print what decides between candidates, or between drives, what failed, and where the report is."""
    shown = _show_drives if "parts" in document else _show_ranking
    shown(console, document)
    labels = [entry["label"] for entry in document.get("drives", ())] or [""]
    for label, part in zip(labels, document.get("parts", [document]), strict=True):
        place = f" on {label}" if label else ""
        for candidate in part["candidates"]:
            for fault in candidate["faults"]:
                words = f"{candidate['label']}{place}: {fault['kind']}: {fault['message']}"
                console.print(plain(words, "bold red"))
    for page in pages:
        console.print(plain(f"report: {page}"))


def _show_ranking(console: Console, document: dict[str, Any]) -> None:
    ranking = comparison_of(document["kind"]).ranking
    figures = [made for made in ranking.columns if not ranking.printed or made.name in ranking.printed]
    heads = ("required failed", "points held", *(made.heading.format(first="first") for made in figures))
    listed = table("place", "candidate", *heads, right=("place", *heads))
    for row in document["tables"]["ranking"]:
        listed.add_row(
            plain(row["status"] if row["rank"] is None else row["rank"]),
            plain(row["candidate"]),
            *_failed_and_held(row, ranking.count),
            *(_written(made, row) for made in figures),
        )
    console.print(listed)
    _show_differences(console, document)
    console.print(plain(f"rule: {document['rule']}"))
    if ranking.remark:
        console.print(plain(ranking.remark))


def _failed_and_held(row: Mapping[str, Any], points: str = "points") -> tuple[str, str]:
    """Write how many required checks a candidate fails, and how many operating points it holds of those there are."""
    failed = row["required_failed"]
    return "–" if failed is None else str(failed), f"{row['points_held']} of {row[points]}"


def _written(made: Figure, row: Row) -> str:
    """Write a number, without a negative zero."""
    value = row[made.name]
    if made.digits is None:
        return "–" if value is None else figure(value)
    return number(value if value is None else round(value, made.digits) + 0.0, made.digits)


def _show_differences(console: Console, document: dict[str, Any]) -> None:
    rows = [
        row
        for row in document["tables"].get("differences", ())
        if row["where"].startswith(("drawn", "drive cycle")) and row["mean_difference"] is not None
    ]
    if not rows:
        return
    figures = (Figure("mean_difference", "difference"), Figure("low", "from"), Figure("high", "to"))
    heads = tuple(made.heading for made in figures)
    listed = table("where", "first less second", *heads, "pairs", "unit", "verdict", right=heads)
    for row in rows:
        listed.add_row(
            plain(row["where"]),
            plain(f"{row['first']} − {row['second']}"),
            *(_written(made, row) for made in figures),
            str(row["pairs"]) + (f" (+ {row['left_out']} lost)" if row["left_out"] else ""),
            plain(row["unit"]),
            plain(row["verdict"]),
        )
    console.print(listed)


def _show_drives(console: Console, document: dict[str, Any]) -> None:
    heads = ("failed", "held", *(made.heading for made in _SUMMARY))
    listed = table("candidate", "drive", *heads, right=heads)
    for row in document["tables"]["summary"]:
        listed.add_row(
            plain(row["candidate"]),
            plain(row["drive"] if row["status"] == "compared" else f"{row['drive']}: {row['status']}"),
            *_failed_and_held(row),
            *(_written(made, row) for made in _SUMMARY),
        )
    console.print(listed)
    for words in (document["bases"], document["losses"], _SUMMARY_REMARK):
        console.print(plain(words))
    for row in document["tables"]["drives"]:
        reached = row["constant_power_up_to_pu"]
        words = "rated power nowhere"
        if reached is not None:
            words = f"rated power up to {reached:.2f} pu of base speed"
        console.print(plain(f"{row['drive']}: {words}, whatever the controller, within overspeed"))
