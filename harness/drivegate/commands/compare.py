"""``drivegate compare``: several candidates side by side, with a ranking."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from drivegate.commands.completion import complete_candidate
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import (
    WholeNumber,
    drives_option,
    effort_option,
    folder_option,
    isolation_options,
    json_option,
    named_drive,
    workers_option,
)
from drivegate.output.failure import ExitCode, Failure, complain, failure_of

if TYPE_CHECKING:
    from rich.console import Console

DEFAULT_OUTPUT = "drivegate-comparison"


@click.command("compare")
@click.argument(
    "candidates", nargs=-1, required=True, metavar="CANDIDATE...", shell_complete=complete_candidate
)
@folder_option(DEFAULT_OUTPUT, "Folder of the report.")
@drives_option
@effort_option("Number of operating points, disturbances and repetitions.")
@click.option(
    "--seed",
    type=WholeNumber(0, 2**63 - 1),
    show_default="0",
    help="Seed of noise, of drawn plants, and of the checks' search.",
)
@workers_option
@isolation_options
@click.option(
    "--checks/--no-checks",
    default=True,
    show_default=True,
    help="Compare the margins of all checks too, at quick effort.",
)
@click.option(
    "--cycle",
    show_default="ece-15",
    metavar="NAME|FILE",
    help="A built-in drive cycle, or a CSV file with time_s and speed_km_h; not for drives of duty ratios.",
)
@json_option
def command(
    candidates: tuple[str, ...],
    output: Path,
    drives: tuple[str, ...],
    effort: str,
    seed: int | None,
    workers: int | None,
    checks: bool,
    cycle: str | None,
) -> Outcome:
    """Compare every CANDIDATE over the same operating points, disturbances, noise and drive cycle.

    The report ranks them, and shows who wins where and by how much. A CANDIDATE is whatever drivegate check takes.
    With more than one --drive, the same candidates run on each at the same shares of its range and rating, and the
    report puts the drives side by side, absolute and per unit. Controllers of duty ratios are compared by losses,
    currents and ripple over what is possible, and by their steps.
    The exit code is 0 when the report is complete, whatever the candidates do, 2 when one is refused, 3 after a
    fault of drivegate.
    """
    from drivegate.studies.compare.compare import compare
    from drivegate.studies.compare.compared_drive import ComparisonOptions

    named = [found for drive in drives if (found := named_drive(drive)) is not None]
    ending = compare(candidates, named, output, ComparisonOptions(effort, seed, workers, checks, cycle))
    if ending.document is None and len(ending.refused) == 1:
        raise ending.refused[0][1]
    failures = [failure_of(error).about(specification) for specification, error in ending.refused]
    for failure, (_, error) in zip(failures, ending.refused, strict=True):
        complain(failure, error)
    code = max((failure.exit_code for failure in failures), default=int(ExitCode.PASSED))
    all_failures = Failure("; ".join(failure.message for failure in failures), code)
    document = ending.document or all_failures.document()

    def show(console: Console) -> None:
        if ending.document is None:
            return
        from drivegate.studies.compare.display import show_comparison

        show_comparison(console, ending.document, ending.pages or (output,))

    return Outcome(document, show, code)
