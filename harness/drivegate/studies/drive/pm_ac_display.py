"""What a PM AC drive can do, on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.drives.pm_ac_words import pm_ac_facts
from drivegate.output.console import number, plain, table
from drivegate.studies.drive.closing import show_closing

if TYPE_CHECKING:
    from rich.console import Console

_COLUMNS: Final = (
    ("speed_rpm", "rpm", 0),
    ("rated_torque_nm", "rated N·m", 2),
    ("greatest_torque_nm", "most N·m", 2),
    ("greatest_power_w", "most W", 0),
    ("greatest_direct_a", "d A", 2),
    ("greatest_quadrature_a", "q A", 2),
    ("least_current_a", "least A", 2),
    ("direct_a", "d A", 2),
    ("voltage_v", "V", 1),
    ("loss_w", "loss W", 1),
    ("least_loss_w", "least W", 1),
)


def show_pm_ac_drive(console: Console, document: dict[str, Any], name: str) -> None:
    """Print what a drive can do over speed, and what follows from its limits."""
    rating = document["rating"]
    title = (
        f"{document['drive']}: {rating['rated_power_w']:g} W from {rating['base_speed_rpm']:g} to "
        f"{rating['highest_speed_rpm']:g} rpm, {rating['current_limit_a']:g} A"
    )
    heads = [head for _, head, _ in _COLUMNS]
    listed = table(*heads, right=tuple(heads), title=title)
    for point in document["points"]:
        listed.add_row(*(number(point[key], digits) for key, _, digits in _COLUMNS))
    console.print(listed)
    console.print(
        plain(
            "most: torque and power within the current limit and the undistorted voltage, and the currents that give "
            "it; least: current for rated torque, its part along the magnet's axis, the voltage it takes and the loss "
            "it costs, beside the least loss of all",
            "dim",
        )
    )
    for words in (*pm_ac_facts(document), _best(document)):
        console.print(plain(words))
    following = (
        f"drivegate check foc --drive {name}" if document["files"] else "the same with --plot drive.svg"
    )
    show_closing(console, document, following)


def _best(document: dict[str, Any]) -> str:
    """Tell the most efficient place of the map."""
    charted = document["efficiency_map"]
    places = [
        (value, speed, torque)
        for speed, *row in zip(
            charted["speed_rpm"], charted["torque_nm"], charted["efficiency_percent"], strict=True
        )
        for torque, value in zip(*row, strict=True)
        if value is not None
    ]
    if not places:
        return "no torque of the efficiency map is within reach"
    value, speed, torque = max(places)
    return (
        f"at least loss the efficiency is at most {value:.4g} %, of copper and core alone, near {speed:.4g} rpm and "
        f"{torque:.4g} N·m"
    )
