"""What a PM AC drive can do, on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

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
    for words in _facts(document):
        console.print(plain(words))
    for row in document["unreachable"]:
        console.print(plain(f"out of reach: {row['message']}", "bold red"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    following = (
        f"drivegate check foc --drive {name}" if document["files"] else "the same with --plot drive.svg"
    )
    console.print(plain(f"next: {following}", "dim"))


def _facts(document: dict[str, Any]) -> tuple[str, ...]:
    limit, magnet = document["rating"]["current_limit_a"], document["magnet_current_a"]
    end = document["rated_power_up_to_rpm"]
    reach = "without end" if end is None else f"up to {end:.5g} rpm"
    return (
        f"the current limit uses up the undistorted {document['undistorted_voltage_v']:.4g} V of a phase at "
        f"{document['voltage_used_up_at_rpm']:.5g} rpm; six steps would give {document['six_step_voltage_v']:.4g} V",
        f"the magnet's flux is worth {magnet:.4g} A along its axis, "
        + (
            f"within the limit of {limit:g} A: the speed range is unbounded"
            if magnet <= limit
            else f"above the limit of {limit:g} A"
        )
        + f"; rated power is there {reach}",
        f"a step every {1e6 * document['control_period_s']:.4g} µs; a steady state is judged "
        f"{document['settling_s']:g} s after a change",
    )
