"""What a drive can do, on the console."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from drivegate.drives.envelope_words import facts
from drivegate.output.console import number, plain, table
from drivegate.studies.drive.closing import show_closing

if TYPE_CHECKING:
    from rich.console import Console

_COLUMNS: Final = (
    ("speed_rpm", "rpm", "rpm", 0),
    ("rated_torque_nm", "rated N·m", "rated", 2),
    ("greatest_torque_nm", "most N·m", "most", 2),
    ("greatest_torque_deg", "at °", "", 1),
    ("greatest_power_w", "most W", "", 0),
    ("torque_without_advance_nm", "N·m at 0°", "at 0°", 2),
    ("edge_deg", "edge °", "edge", 1),
    ("advance_deg", "best °", "best", 1),
    ("line_deg", "line °", "line", 1),
    ("current_sum_a", "Σ|i| A", "Σ|i|", 1),
    ("input_power_w", "input W", "", 0),
    ("ripple_percent", "ripple %", "ripple", 1),
)
"""Keys of a point, with their heads, those for a narrow console, which has no room for all, and their digits."""
_SMALL_ONES: Final = ("_nm", "_w")
_WIDTH: Final = 116
_SHOWN: Final = (0, 2, 4, 5, 8, 12, 16, 20, 24, 29, 34)
"""Places of the points that the table has; all are in the document."""


def show_drive(console: Console, document: dict[str, Any], name: str, required: Sequence[str]) -> None:
    """Print what a drive can do over speed, what it is too little for, and what is required of its controllers."""
    columns = [
        (key, head if console.width >= _WIDTH else short, digits)
        for key, head, short, digits in _COLUMNS
        if short or console.width >= _WIDTH
    ]
    heads = [head for _, head, _ in columns]
    listed = table(*heads, right=tuple(heads), title=_title(document))
    finer = _finer(document)
    for place in _SHOWN:
        point = document["points"][place]
        shown = (
            (point[key], digits + (finer if key.endswith(_SMALL_ONES) else 0)) for key, _, digits in columns
        )
        listed.add_row(*(number(value, digits) for value, digits in shown))
    console.print(listed)
    console.print(
        plain(
            "rated, most, at 0°: torques (N·m) of rated power, and at the current limit with the best angle and none; "
            "edge: smallest angle for rated torque (°); best: that of least Σ|i|, where Σ|i| (A), input and ripple (%, "
            "ideal regulator) are; line: recommended initial angle",
            "dim",
        )
    )
    for words in (*facts(document), *required):
        console.print(plain(words))
    if not document["has_band"]:
        console.print(
            plain(
                "the band is so narrow that it is taken as none, which the means do not show; a check computes each "
                "chop, and takes long"
            )
        )
    show_closing(console, document, _next(document, name))


def _finer(document: dict[str, Any]) -> int:
    """Count the further digits that torque and power of a small drive take to be told apart."""
    torque = document["points"][0]["rated_torque_nm"]
    return sum(torque < least for least in (1.0, 0.1, 0.01))


def _title(document: dict[str, Any]) -> str:
    rating = document["rating"]
    return (
        f"{document['drive']}: {rating['rated_power_w']:g} W from {rating['base_speed_rpm']:g} to "
        f"{rating['highest_speed_rpm']:g} rpm, {rating['current_limit_a']:g} A"
    )


def _next(document: dict[str, Any], name: str) -> str:
    if not document["files"]:
        return "the same with --plot drive.svg"
    return f"drivegate map reference --drive {name} --plot reference.png shows what a controller makes of it"
