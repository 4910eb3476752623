"""What a drive can do, on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

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
_WIDTH: Final = 116
_SHOWN: Final = (0, 2, 4, 5, 8, 12, 16, 20, 24, 29, 34)
"""Places of the points that the table has; all are in the document."""


def show_drive(console: Console, document: dict[str, Any], name: str) -> None:
    """Print what a drive can do over speed, what it is too little for, and what it means for a controller."""
    columns = [
        (key, head if console.width >= _WIDTH else short, digits)
        for key, head, short, digits in _COLUMNS
        if short or console.width >= _WIDTH
    ]
    heads = [head for _, head, _ in columns]
    listed = table(*heads, right=tuple(heads), title=_title(document))
    for place in _SHOWN:
        point = document["points"][place]
        listed.add_row(*(number(point[key], digits) for key, _, digits in columns))
    console.print(listed)
    console.print(
        plain(
            "rated, most, at 0°: torques (N·m) of rated power, and at the current limit with the best angle and none; "
            "edge: smallest angle for rated torque (°); best: that of least Σ|i|, where Σ|i| (A), input and ripple (%, "
            "ideal regulator) are; line: recommended initial angle",
            "dim",
        )
    )
    for words in _facts(document):
        console.print(plain(words))
    if not document["has_band"]:
        console.print(plain("the band is so narrow that it is taken as none, which the means do not show"))
    for row in document["unreachable"]:
        console.print(plain(f"out of reach: {row['message']}", "bold red"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    console.print(plain(_next(document, name), "dim"))


def _title(document: dict[str, Any]) -> str:
    rating = document["rating"]
    return (
        f"{document['drive']}: {rating['rated_power_w']:g} W from {rating['base_speed_rpm']:g} to "
        f"{rating['highest_speed_rpm']:g} rpm, {rating['current_limit_a']:g} A"
    )


def _facts(document: dict[str, Any]) -> list[str]:
    return [_line(document), _without_advance(document), _times(document), _meaning(document)]


def _line(document: dict[str, Any]) -> str:
    line, base = document["line"], document["rating"]["base_speed_rpm"]
    if line["least_in_hand_percent"] is None:
        return "line of initial angles: none, since rated power is out of reach at every speed"
    in_hand, where = line["least_in_hand_percent"], line["least_in_hand_at_rpm"]
    least = (
        f"it leaves the least torque in hand at {where:g} rpm, {in_hand:.1f} %"
        if in_hand >= 0.0
        else f"it misses rated torque most at {where:g} rpm, by {-in_hand:.1f} %"
    )
    return (
        f"line of initial angles: 0° below {base:g} rpm, then {line['start_deg']:.1f}° + "
        f"{line['slope_deg_per_rpm']:.3g}° per rpm above; {least}"
    )


def _without_advance(document: dict[str, Any]) -> str:
    highest = document["rated_torque_without_advance_up_to_rpm"]
    base = document["rating"]["base_speed_rpm"]
    where = "at no speed" if highest is None else f"up to {highest:.0f} rpm"
    return f"rated torque without advance: {where}; base speed is {base:g} rpm"


def _times(document: dict[str, Any]) -> str:
    times = {key: _seconds(value) for key, value in document["time_scales"].items() if key.endswith("_s")}
    return (
        f"times: L/R {times['electrical_s']}, current up to its limit {times['current_rise_s']}, "
        f"J·ω/T {times['mechanical_at_base_s']} at base speed and {times['mechanical_at_highest_s']} at the highest, "
        f"base to highest speed with rated power {times['run_up_s']}"
    )


def _meaning(document: dict[str, Any]) -> str:
    scales = document["time_scales"]
    half_cycle, drift = scales["half_cycle_s"], scales["drift_s"]
    reason = (
        "half an electrical cycle at highest speed"
        if half_cycle <= drift
        else "in which a lost rated torque costs 1 % of base speed"
    )
    search = scales["search_s"]
    settling = (
        ""
        if search != search
        else f"; a search from the line to the least Σ|i| takes about {_seconds(search)}, "
        f"{_seconds(scales['decision_s'])} a decision"
    )
    return (
        f"control period: {scales['electrical_frequency_hz']:.3g} Hz at highest speed, so at most "
        f"{_seconds(scales['largest_control_period_s'])}, {reason}{settling}"
    )


def _seconds(value: float) -> str:
    if value == float("inf"):
        return "endless"
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def _next(document: dict[str, Any], name: str) -> str:
    if document["unreachable"]:
        return "next: try a rating with --set rated_power_w=…, or another limit with --set current_limit_a=…"
    if not document["files"]:
        return "next: the same with --plot drive.svg"
    return f"next: drivegate map reference --drive {name} --plot reference.png shows what a controller makes of it"
