"""One run of a candidate, and its summary in people's units."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.checks.check import Record
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Contract
from drivegate.drives.running import recorded
from drivegate.output.console import number, print_ending, print_line, table
from drivegate.output.waiting import report_slow, with_compiled_kernels
from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    import pandas
    from numpy.typing import NDArray

SCHEMA: Final = 1
MOST_ROWS: Final = 1_000_000
"""Maximum number of rows of a trace; of a longer run every n-th control period is recorded."""


def simulated(candidate: Candidate, scenario: Scenario) -> Record | Fault:
    with_compiled_kernels([scenario.drive])
    with Judge(candidate, on_slow=report_slow) as judge:
        return judge.run(Job(run_once, scenario))


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> Record:
    every = -(-scenario.control_periods // MOST_ROWS)
    return recorded(loaded, scenario, loaded.controller(), trace_every=every, keeps_steps=True)


def trace_frame(scenario: Scenario, run: Any, steps: NDArray[Any] | None = None) -> pandas.DataFrame:
    """Make a table of a run's signals, with what its controller sensed where that was kept."""
    import pandas

    contract = contract_of(scenario.drive)
    sensed = {} if steps is None else contract.sensed_signals(scenario, run, steps)
    return pandas.DataFrame({**contract.signals(run), **sensed})


def document_of(candidate: Candidate, scenario: Scenario, ended: Record | Fault) -> dict[str, Any]:
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "simulation",
        "candidate": {"name": candidate.name, "kind": candidate.kind, "hash": candidate.content_hash},
        "scenario": scenario.name,
        "drive": scenario.drive.identity(),
        "duration_s": scenario.duration_s,
        "control_period_s": scenario.control_period_s,
        "fault": None,
    }
    if isinstance(ended, Fault):
        return document | {"fault": asdict(ended) | {"kind": ended.kind.value}}
    return document | contract_of(scenario.drive).summary(ended)


def show_run(console: Console, contract: Contract, document: dict[str, Any], hint: str) -> None:
    """Print the summary of a run, and its steady windows."""
    summary = document["summary"]
    heading = f"{document['candidate']['name']}: {document['scenario']}, {document['duration_s']:g} s"
    listed = table("quantity", "value", "unit", right=("value",), title=heading)
    for key, name, unit in contract.summary_rows:
        listed.add_row(name, number(summary[key]), unit)
    for key, place in (("energy_residual", "energy"), ("shaft_residual", "shaft energy")):
        listed.add_row(f"{place} residual, worst control period", f"{summary[key]:.1e}", "of throughput")
    console.print(listed)
    if document["windows"]:
        columns = contract.window_columns
        headings = ("steady from (s)", "to (s)", *(heading for _, heading in columns))
        windows = table(*headings, right=headings)
        for row in document["windows"]:
            values = (number(row[key]) for key, _ in columns)
            windows.add_row(number(row["start_s"], 1), number(row["end_s"], 1), *values)
        console.print(windows)
    for words in document["clamped"]:
        print_line(console, words, "bold yellow")
    print_ending(console, document["files"], hint)


def show_fault(console: Console, document: dict[str, Any]) -> None:
    fault = document["fault"]
    print_line(console, f"{document['candidate']['name']}: {fault['kind']}: {fault['message']}", "bold red")
    if fault["time"] is not None:
        print_line(console, f"  in step {fault['step']}, at {fault['time']:g} s")
    for line in fault["traceback"].splitlines():
        print_line(console, f"  {line}", "dim")
