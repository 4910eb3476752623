"""Fitted constants of a drive on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console

_UNITS: Final = {
    "emf_constant_v_s_per_rad": "V·s/rad",
    "inductance_h": "H",
    "resistance_ohm": "Ω",
    "emf_flat_deg": "°",
}
_DIGITS: Final = 5


def show_fit(console: Console, document: dict[str, Any], name: str) -> None:
    """Print points and constants, and what the points do not tell."""
    heads = ("rpm", "°", "A", "N·m", "fitted N·m", "difference")
    points = table(*heads, right=heads)
    for point in document["points"]:
        advance, torque, fitted = point["advance_deg"], point["torque_nm"], point["fitted_torque_nm"]
        angle = "best" if advance is None or advance != advance else f"{advance:g}"
        values = (number(value) for value in (torque, fitted, fitted - torque))
        points.add_row(f"{point['speed_rpm']:g}", angle, f"{point['current_a']:g}", *values)
    console.print(points)
    columns = ("fitted", "±", "drive's own")
    constants = table("constant", *columns, "unit", right=columns)
    for row in document["constants"]:
        uncertainty = row["uncertainty"]
        spread = "–" if uncertainty is None or uncertainty != uncertainty else f"{uncertainty:.2g}"
        fitted, stored = f"{row['fitted']:.{_DIGITS}g}", f"{row['stored']:.{_DIGITS}g}"
        constants.add_row(row["key"], fitted, spread, stored, _UNITS[row["key"]])
    console.print(constants)
    console.print(
        plain(
            f"the fit leaves {document['rms_residual_nm']:.2g} N·m (rms); condition {document['condition']:.0f}; "
            "± is one standard deviation; ideal regulator, no core loss"
        )
    )
    for words in _doubts(document):
        console.print(plain(words, "yellow"))
    console.print(plain(_next(document, name), "dim"))


def _doubts(document: dict[str, Any]) -> list[str]:
    """Tell what of the fit cannot be relied on."""
    rows = document["constants"]
    unknown = [row for row in rows if row["uncertainty"] is None or row["uncertainty"] != row["uncertainty"]]
    doubts = []
    if unknown:
        doubts.append(
            "as many constants as points: nothing tells how sure they are; give more points, or a column uncertainty_nm"
        )
    if not document["converged"]:
        doubts.append("the search has not come to rest: other constants explain the points as well")
    for row in rows:
        if not row["determined"]:
            doubts.append(
                f"the points do not tell {row['key']}; keep it with --keep {row['key']}, or measure where it matters"
            )
        elif row["at_bound"]:
            doubts.append(
                f"{row['key']} has gone to the bound of the search; is a unit wrong, or the start far off?"
            )
    return doubts


def _next(document: dict[str, Any], name: str) -> str:
    if not all(row["determined"] and not row["at_bound"] for row in document["constants"]):
        return "next: the same with more points, or with --keep KEY for each constant that is known otherwise"
    settings = (f"--set {row['key']}={row['fitted']:.{_DIGITS}g}" for row in document["constants"])
    return f"next: drivegate drive {name} {' '.join(settings)}"
