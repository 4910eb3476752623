"""What a drive can do, on the console."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, sqrt
from typing import Any, Final

from rich.console import Console

from drivegate.drives.abilities import ability_of
from drivegate.drives.power_reach import setting_words
from drivegate.drives.sheet_values import sheet_in_words
from drivegate.output.console import number, print_ending, print_line, table
from drivegate_cases.documents.wording import decimal_exponent
from drivegate_cases.drive.drive_document import DriveDocument

_UNITS: Final = {
    "emf_constant_v_s_per_rad": "V·s/rad",
    "inductance_h": "H",
    "resistance_ohm": "Ω",
    "emf_flat_deg": "°",
}
_DIGITS: Final = 5


@dataclass(frozen=True)
class _Layout:
    """How the points of an envelope are printed."""

    columns: tuple[tuple[str, str, str, int], ...]
    """Keys of a point, with their heads, those for a narrow console, which has no room for all, and their digits."""
    places: tuple[int, ...]
    """Places of the points that the table has, or none for all; all are in the document."""
    legend: str
    """What the heads mean."""
    of_link: str = field(kw_only=True, default="")
    """What further heads of a drive mean whose link is not ideal."""
    advice: str
    """What to do next with a drive called ``{name}``."""


_ANGLES: Final = _Layout(
    columns=(
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
    ),
    places=(0, 2, 4, 5, 8, 12, 16, 20, 24, 29, 34),
    legend="rated, most, at 0°: torques (N·m) of rated power, and at the current limit with the best angle and none; "
    "edge: smallest angle for rated torque (°); best: that of least Σ|i|, where Σ|i| (A), input and ripple (%, "
    "ideal regulator) are; line: recommended initial angle",
    advice="drivegate map reference --drive {name} --plot reference.png shows what a controller makes of it",
)
_DUTY_RATIOS: Final = _Layout(
    columns=(
        ("speed_rpm", "rpm", "rpm", 0),
        ("rated_torque_nm", "rated N·m", "rated N·m", 2),
        ("greatest_torque_nm", "most N·m", "most N·m", 2),
        ("greatest_power_w", "most W", "most W", 0),
        ("greatest_direct_a", "d A", "d A", 2),
        ("greatest_quadrature_a", "q A", "q A", 2),
        ("braking_torque_nm", "brake N·m", "brake N·m", 2),
        ("burning_torque_nm", "burnt N·m", "burnt N·m", 2),
        ("least_current_a", "least A", "least A", 2),
        ("direct_a", "d A", "d A", 2),
        ("voltage_v", "V", "V", 1),
        ("loss_w", "loss W", "loss W", 1),
        ("least_loss_w", "least W", "least W", 1),
    ),
    places=(),
    legend="most: torque and power within the current limit and the undistorted voltage, and the currents that give "
    "it; least: current for rated torque, its part along the magnet's axis, the voltage it takes and the loss "
    "it costs, next to the least loss of all",
    of_link="brake: greatest braking torque that the link takes; burnt: the same without giving energy back",
    advice="drivegate check foc --drive {name}",
)
_LAYOUTS: Final = {"current": _ANGLES, "duty": _DUTY_RATIOS}
"""By the names of contracts."""
_WIDTH: Final = 116
_FEWEST: Final = 3
"""Digits of the greatest value of a column, at least."""
_MOST_DECIMALS: Final = 9
_PARTS: Final = {"greatest_direct_a": "greatest_quadrature_a", "direct_a": "least_current_a"}
"""Columns with parts of a current, which may be 0 but for rounding, by the columns that set their digits."""


def show_drive(console: Console, document: dict[str, Any], name: str, drive: DriveDocument) -> None:
    """Print what a drive can do over speed, what it is too little for, and what is required of its controllers."""
    layout, is_wide, rating = _LAYOUTS[drive.contract], console.width >= _WIDTH, document["rating"]
    base, highest = rating["base_speed_rpm"], rating["highest_speed_rpm"]
    speeds = f"from {base:g} to {highest:g} rpm" if highest > base else f"at {base:g} rpm"
    title = f"{document['drive']}: {rating['rated_power_w']:g} W {speeds}, {rating['current_limit_a']:g} A"
    places = layout.places or range(len(document["points"]))
    points = [document["points"][place] for place in places]
    columns = [
        (
            key,
            head if is_wide else short,
            _decimals([point[_PARTS.get(key, key)] for point in points], digits, key == "speed_rpm"),
        )
        for key, head, short, digits in layout.columns
        if (short or is_wide) and key in points[0]
    ]
    heads = [head for _, head, _ in columns]
    print_line(
        console, f"as a data sheet: {sheet_in_words(document['data_sheet'], drive.machine.pole_pairs)}"
    )
    for words in document["doubts"]:
        print_line(console, f"warning: {words}", "yellow")
    listed = table(*heads, right=tuple(heads), title=title)
    for point in points:
        listed.add_row(*(number(point[key], decimals) for key, _, decimals in columns))
    console.print(listed)
    further = f"; {layout.of_link}" if "braking_torque_nm" in points[0] else ""
    print_line(console, layout.legend + further, "dim")
    ability = ability_of(drive)
    for words in (*ability.facts(document), *ability.required(drive)):
        print_line(console, words)
    advice = layout.advice.format(name=name) if document["files"] else "the same with --plot drive.svg"
    for row in document["following"]:
        value = setting_words({row["key"]: row["value"]})
        print_line(console, f"from the data sheet: {value} follows from {row['from']}")
    refused = document["unreachable"]
    suspects = document["suspects"]
    for row in refused:
        # What follows from a wrong unit is no value to write down.
        message = row["message"].partition("; a check accepts")[0] if suspects else row["message"]
        print_line(console, f"a check refuses this drive: {message}", "bold red")
    if refused:
        advice = _corrections(suspects, document["doubts"]) or _changes(refused)
    print_ending(console, document["files"], advice)


def _decimals(values: list[float | None], usual: int, is_apart: bool) -> int:
    """Return how many decimals a column needs: three digits of the greatest value, and no two equal speeds."""
    known = [value for value in values if value is not None and isfinite(value)]
    greatest = max(map(abs, known), default=0.0)
    decimals = usual if greatest == 0.0 else max(usual, _FEWEST - 1 - decimal_exponent(greatest))
    while (
        is_apart
        and decimals < _MOST_DECIMALS
        and len({number(value, decimals) for value in known}) < len(set(known))
    ):
        decimals += 1
    return decimals


def _corrections(suspects: Mapping[str, str], doubts: Sequence[str]) -> str:
    """Return what to correct first: the values that are far off their kind; nothing where none is."""
    known = [*suspects.values(), *doubts]
    return (
        f"correct {', '.join(suspects) or 'this'} first, since the rest follows from it: {known[0]}"
        if known
        else ""
    )


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


def show_fit(console: Console, document: dict[str, Any], name: str) -> None:
    """Print points and constants, and what the points do not show."""
    heads = ("rpm", "°", "A", "N·m", "fitted N·m", "difference")
    points = table(*heads, right=heads)
    for point in document["points"]:
        advance, torque, fitted = point["advance_deg"], point["torque_nm"], point["fitted_torque_nm"]
        angle = "best" if advance is None or advance != advance else f"{advance:g}"
        values = (number(value) for value in (torque, fitted, fitted - torque))
        points.add_row(f"{point['speed_rpm']:g}", angle, f"{point['current_a']:g}", *values)
    console.print(points)
    if not document["explained"]:
        print_line(console, _unexplained(document), "bold red")
        print_line(console, "next: the same with points of this drive, or with another drive", "dim")
        return
    columns = ("fitted", "±", "drive's own")
    constants = table("constant", *columns, "unit", right=columns)
    for row in document["constants"]:
        uncertainty = row["uncertainty"]
        spread = "–" if uncertainty is None or uncertainty != uncertainty else f"{uncertainty:.2g}"
        fitted, stored = f"{row['fitted']:.{_DIGITS}g}", f"{row['stored']:.{_DIGITS}g}"
        constants.add_row(row["key"], fitted, spread, stored, _UNITS[row["key"]])
    console.print(constants)
    print_line(
        console,
        f"the fit leaves {document['rms_residual_nm']:.2g} N·m (rms); condition {document['condition']:.0f}; "
        "± is one standard deviation; ideal regulator, no core loss",
    )
    for words in _doubts(document):
        print_line(console, words, "yellow")
    print_line(console, _next(document, name), "dim")


def _unexplained(document: dict[str, Any]) -> str:
    rows = document["points"]
    torque = sqrt(sum(row["torque_nm"] ** 2 for row in rows) / len(rows))
    return (
        "no constants explain these torques: the best fit leaves "
        f"{document['rms_residual_nm']:.2g} of {torque:.2g} N·m (rms); are they N·m, rpm, degrees and amperes, and is "
        "the drive of this kind?"
    )


def _doubts(document: dict[str, Any]) -> list[str]:
    """State what of the fit cannot be relied on."""
    rows = document["constants"]
    unknown = [row for row in rows if row["uncertainty"] is None or row["uncertainty"] != row["uncertainty"]]
    doubts = []
    if unknown:
        doubts.append(
            "as many constants as points: nothing shows how sure they are; give more points, or a column uncertainty_nm"
        )
    if not document["converged"]:
        doubts.append("the search has not come to rest: other constants explain the points as well")
    for row in rows:
        if not row["determined"]:
            doubts.append(
                f"the points do not show {row['key']}; keep it with --keep {row['key']}, or measure where it matters"
            )
        elif row["at_bound"]:
            doubts.append(
                f"{row['key']} has gone to the bound of the search; is a unit wrong, or the start far off?"
            )
    return doubts


def _next(document: dict[str, Any], name: str) -> str:
    if not document["usable"]:
        return "next: the same with more points, or with --keep KEY for each constant that is known otherwise"
    settings = (f"--set {row['key']}={row['fitted']:.{_DIGITS}g}" for row in document["constants"])
    return f"next: drivegate drive {name} {' '.join(settings)}"
