"""One run of a candidate on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate.contracts.contract import Contract


def show_run(console: Console, contract: Contract, document: dict[str, Any], hint: str) -> None:
    """Print the summary of a run, and its steady windows."""
    summary = document["summary"]
    heading = f"{document['candidate']['name']}: {document['scenario']}, {document['duration_s']:g} s"
    listed = table("quantity", "value", "unit", right=("value",), title=heading)
    for key, name, unit in contract.summary_rows:
        listed.add_row(name, number(summary[key]), unit)
    listed.add_row(
        "energy residual, worst control period", f"{summary['energy_residual']:.1e}", "of throughput"
    )
    console.print(listed)
    if document["windows"]:
        columns = contract.window_columns
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
