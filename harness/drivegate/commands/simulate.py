"""``drivegate simulate``: one run of a candidate through a scenario."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import chosen_scenario, json_option, motor_options
from drivegate.output.failure import ExitCode

if TYPE_CHECKING:
    from rich.console import Console


_ROWS = (
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
    ("kinetic_residual_j", "kinetic residual of the frozen speed", "J"),
)
_WINDOW_COLUMNS = (
    ("speed_error_worst_rpm", "worst error (rpm)"),
    ("current_sum_mean_a", "Σ|i| (A)"),
    ("torque_mean_nm", "torque (N·m)"),
    ("input_power_mean_w", "input power (W)"),
    ("advance_mean_deg", "angle (°)"),
)


@click.command("simulate")
@click.argument("candidate")
@click.option(
    "--case", required=True, metavar="NAME|FILE", help="A scenario that comes along, or a file of one."
)
@click.option("--csv", type=click.Path(path_type=Path), help="Write the trace as CSV.")
@click.option("--parquet", type=click.Path(path_type=Path), help="Write the trace as Parquet.")
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@motor_options
@json_option
def command(
    candidate: str,
    case: str,
    csv: Path | None,
    parquet: Path | None,
    plot: Path | None,
    motor: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Run CANDIDATE once through a scenario.

    CANDIDATE is a built-in or installed controller's name, module:Class, file.py:Class or a manifest.
    """
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.output.trace_files import check_targets

    resolved = resolve_candidate(candidate)
    scenario = chosen_scenario(case, motor, settings)
    check_targets(csv, parquet, plot)

    from drivegate.candidates.fault import Fault
    from drivegate.output.trace_files import write_plot, write_trace
    from drivegate.studies.simulate.simulate import document_of, simulated, trace_frame

    ended = simulated(resolved, scenario)
    document = document_of(resolved, scenario, ended)
    if isinstance(ended, Fault):
        return Outcome(document, lambda console: _show_fault(console, document), ExitCode.FAILED)
    if csv is not None or parquet is not None or plot is not None:
        frame = trace_frame(ended)
        write_trace(frame, csv, parquet)
        if plot is not None:
            write_plot(frame, plot, f"{resolved.name}: {scenario.name}")
    written = [str(path) for path in (csv, parquet, plot) if path is not None]
    document["files"] = written
    hint = (
        ""
        if plot is not None
        else f"drivegate simulate {quote(candidate)} --case {quote(case)} --plot run.png"
    )
    return Outcome(document, lambda console: _show(console, document, hint))


def _show(console: Console, document: dict[str, Any], hint: str) -> None:
    from drivegate.output.console import number, plain, table

    summary = document["summary"]
    heading = f"{document['candidate']['name']}: {document['scenario']}, {document['duration_s']:g} s"
    listed = table("quantity", "value", "unit", right=("value",), title=heading)
    for key, name, unit in _ROWS:
        listed.add_row(name, number(summary[key]), unit)
    listed.add_row(
        "energy residual, worst control period", f"{summary['energy_residual']:.1e}", "of throughput"
    )
    console.print(listed)
    if document["windows"]:
        headings = tuple(heading for _, heading in _WINDOW_COLUMNS)
        windows = table(
            "steady from (s)", "to (s)", *headings, right=("steady from (s)", "to (s)", *headings)
        )
        for row in document["windows"]:
            values = (number(row[key]) for key, _ in _WINDOW_COLUMNS)
            windows.add_row(number(row["start_s"], 1), number(row["end_s"], 1), *values)
        console.print(windows)
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if hint:
        console.print(plain(f"next: {hint}", "dim"))


def _show_fault(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain

    fault = document["fault"]
    console.print(plain(f"{document['candidate']['name']}: {fault['kind']}: {fault['message']}", "bold red"))
    for line in fault["traceback"].splitlines():
        console.print(plain(f"  {line}", "dim"))
