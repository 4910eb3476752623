"""One run of a candidate on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console

_ROWS: Final = (
    ("speed_final_rpm", "speed at the end", "rpm"),
    ("speed_error_worst_rpm", "speed error, worst", "rpm"),
    ("current_sum_mean_a", "Σ|i|, mean", "A"),
    ("current_peak_a", "phase current, peak", "A"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("input_power_mean_w", "input power, mean", "W"),
    ("shaft_power_mean_w", "shaft power, mean", "W"),
    ("advance_mean_deg", "advance angle, mean", "°"),
    ("advance_final_deg", "advance angle at the end", "°"),
    ("current_reference_final_a", "current reference at the end", "A"),
    ("kinetic_residual_j", "kinetic residual of the held speed", "J"),
)
_DUTY_ROWS: Final = (
    ("speed_final_rpm", "speed at the end", "rpm"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("torque_final_nm", "torque at the end", "N·m"),
    ("direct_current_final_a", "d current at the end", "A"),
    ("quadrature_current_final_a", "q current at the end", "A"),
    ("current_peak_a", "phase current, peak", "A"),
    ("voltage_highest_v", "phase voltage, highest", "V"),
    ("input_power_mean_w", "input power, mean", "W"),
)
_WINDOW_COLUMNS: Final = (
    ("speed_error_worst_rpm", "worst error (rpm)"),
    ("current_sum_mean_a", "Σ|i| (A)"),
    ("torque_mean_nm", "torque (N·m)"),
    ("input_power_mean_w", "input power (W)"),
    ("advance_mean_deg", "angle (°)"),
)
_DUTY_WINDOW_COLUMNS: Final = (
    ("speed_mean_rpm", "speed (rpm)"),
    ("torque_mean_nm", "torque (N·m)"),
    ("direct_current_mean_a", "d (A)"),
    ("quadrature_current_mean_a", "q (A)"),
    ("voltage_mean_v", "voltage (V)"),
)


def show_run(console: Console, document: dict[str, Any], hint: str) -> None:
    """Print the summary of a run, and its steady windows."""
    summary = document["summary"]
    heading = f"{document['candidate']['name']}: {document['scenario']}, {document['duration_s']:g} s"
    listed = table("quantity", "value", "unit", right=("value",), title=heading)
    # The keys of a summary are those of its drive's contract.
    of_duty = "direct_current_final_a" in summary
    for key, name, unit in _DUTY_ROWS if of_duty else _ROWS:
        listed.add_row(name, number(summary[key]), unit)
    listed.add_row(
        "energy residual, worst control period", f"{summary['energy_residual']:.1e}", "of throughput"
    )
    console.print(listed)
    if document["windows"]:
        columns = _DUTY_WINDOW_COLUMNS if of_duty else _WINDOW_COLUMNS
        headings = tuple(heading for _, heading in columns)
        windows = table(
            "steady from (s)", "to (s)", *headings, right=("steady from (s)", "to (s)", *headings)
        )
        for row in document["windows"]:
            values = (number(row[key]) for key, _ in columns)
            windows.add_row(number(row["start_s"], 1), number(row["end_s"], 1), *values)
        console.print(windows)
    for words in document["clamped"]:
        console.print(plain(words, "bold yellow"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if hint:
        console.print(plain(f"next: {hint}", "dim"))


def show_fault(console: Console, document: dict[str, Any]) -> None:
    """Print what ended the run."""
    fault = document["fault"]
    console.print(plain(f"{document['candidate']['name']}: {fault['kind']}: {fault['message']}", "bold red"))
    if fault["time"] is not None:
        console.print(plain(f"  in step {fault['step']}, at {fault['time']:g} s"))
    for line in fault["traceback"].splitlines():
        console.print(plain(f"  {line}", "dim"))
