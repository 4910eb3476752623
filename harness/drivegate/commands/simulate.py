"""``drivegate simulate``: one run of a candidate through a scenario."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

import click

from drivegate.commands.completion import complete_candidate, complete_case
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import (
    chosen_scenario,
    drive_options,
    drive_words,
    isolation_options,
    json_option,
)
from drivegate.output.failure import ExitCode


@click.command("simulate")
@click.argument("candidate", shell_complete=complete_candidate)
@click.option(
    "--case",
    metavar="NAME|FILE",
    shell_complete=complete_case,
    help="An included scenario, or a file of one.",
)
@click.option(
    "--from",
    "report",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="A report of drivegate check, whose run is taken with --run.",
)
@click.option(
    "--run",
    "run",
    metavar="NAME",
    help="A run of that report by its name, or by its check: the counterexample, or the worst run.",
)
@click.option("--csv", type=click.Path(path_type=Path), help="Write the trace as CSV.")
@click.option("--parquet", type=click.Path(path_type=Path), help="Write the trace as Parquet.")
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@drive_options
@isolation_options
@json_option
def command(
    candidate: str,
    case: str | None,
    report: Path | None,
    run: str | None,
    csv: Path | None,
    parquet: Path | None,
    plot: Path | None,
    drive: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Run CANDIDATE once through a scenario.

    CANDIDATE is whatever drivegate check takes.
    """
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.output.trace_files import check_targets

    resolved = resolve_candidate(candidate)
    scenario = chosen_scenario(case, drive, settings, report, run)
    check_targets(csv, parquet, plot)

    from drivegate.candidates.fault import Fault
    from drivegate.contracts.catalogue import contract_of
    from drivegate.drives.kinds import scenario_at_declared_timing
    from drivegate.output.trace_files import write_plot, write_trace
    from drivegate.studies.simulate import document_of, show_fault, show_run, simulated, trace_frame

    scenario = scenario_at_declared_timing(scenario, [resolved])
    ended = simulated(resolved, scenario)
    document = document_of(resolved, scenario, ended)
    if isinstance(ended, Fault):
        return Outcome(document, lambda console: show_fault(console, document), ExitCode.FAILED)
    contract = contract_of(scenario.drive)
    if csv is not None or parquet is not None or plot is not None:
        frame = trace_frame(scenario, ended.run, ended.steps)
        write_trace(frame, csv, parquet)
        if plot is not None:
            write_plot(frame, plot, f"{resolved.name}: {scenario.name}", contract.panels_of(scenario))
    document["files"] = [str(path) for path in (csv, parquet, plot) if path is not None]
    named = (
        f"--from {quote(str(report))} --run {quote(str(run))}" if case is None else f"--case {quote(case)}"
    )
    again = f"drivegate simulate {quote(candidate)} {named}{drive_words(drive, settings)}"
    hint = "" if plot is not None else f"{again} --plot run.png"
    return Outcome(document, lambda console: show_run(console, contract, document, hint))
