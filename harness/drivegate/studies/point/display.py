"""The steady state at one operating point on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.current.checks.feasible_angles import given_below_limit
from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate_models.steady.plant import AnyDrive

_ROWS: Final = (
    ("speed_rpm", "speed", "rpm"),
    ("advance_deg", "advance angle", "°"),
    ("current_reference_a", "current reference", "A"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("torque_lowest_nm", "torque, least", "N·m"),
    ("torque_highest_nm", "torque, greatest", "N·m"),
    ("torque_ripple_percent", "torque ripple, peak to peak over mean", "%"),
    ("torque_ripple_one_sided_percent", "torque ripple, greatest deviation over mean", "%"),
    ("current_sum_a", "Σ|i|, mean", "A"),
    ("exchanged_power_w", "power exchanged with the supply", "W"),
    ("input_power_w", "input power, net", "W"),
    ("copper_loss_w", "copper loss", "W"),
    ("core_loss_w", "core loss", "W"),
    ("current_peak_a", "phase current, peak", "A"),
)


def show_point(console: Console, document: dict[str, Any], drive: AnyDrive, torque: float | None) -> None:
    """Print the values, and what they do not hold for."""
    values = table("quantity", "value", "unit", right=("value",))
    for key, name, unit in _ROWS:
        values.add_row(name, number(document[key]), unit)
    console.print(values)
    if not document["feasible"]:
        below = document.get("reference_below_limit_a")
        lost = "" if below is None else f"; {given_below_limit(below)}"
        reason = (
            f"{torque:g} N·m cannot be produced here at the current limit of {drive.current_limit:g} A; "
            f"the values are those at the limit{lost}"
            if torque is not None
            else f"the current reference exceeds the limit of {drive.current_limit:g} A"
        )
        console.print(plain(f"not feasible: {reason}", "yellow"))
    if document.get("averaged_cycles", 1) > 1:
        console.print(
            plain(
                f"no periodic state exists here; means are over {document['averaged_cycles']} electrical cycles"
            )
        )
    if not document["unique"]:
        console.print(
            plain(
                "the periodic state is not unique: without resistance, a current that reaches neither zero nor its "
                "limit retains any dc offset; the values are those of one such state",
                "yellow",
            )
        )
    console.print(
        plain("next: another angle shows what Σ|i| costs; drivegate map computes many at once", "dim")
    )
