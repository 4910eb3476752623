"""``drivegate selftest``: the checks checked, on controllers with known faults and on correct ones."""

from __future__ import annotations

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import drive_option, json_option, named_drive
from drivegate.output.failure import ExitCode

ALL_SEEDS = 1000


@click.command("selftest")
@click.option(
    "--fault",
    "faults",
    metavar="NAME",
    multiple=True,
    help="Only this faulty controller, and no correct designs; may be given again.",
)
@click.option(
    "--seeds",
    type=click.IntRange(1, ALL_SEEDS),
    default=1,
    show_default=True,
    help="Number of seeds of the search, from 0 on.",
)
@click.option(
    "--effort",
    type=click.Choice(["quick", "default", "nightly"]),
    default="default",
    show_default=True,
    help="Number of scenarios that are drawn.",
)
@click.option(
    "--search/--no-search",
    default=True,
    show_default=True,
    help="Climb toward small margins, or draw scenarios at random.",
)
@click.option(
    "--drawn-only",
    is_flag=True,
    help="Leave the fixed scenarios out, and the correct designs: what would drawing alone have caught?",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Processes; by default as many as there are processors."
)
@drive_option
@json_option
def command(
    faults: tuple[str, ...],
    seeds: int,
    effort: str,
    search: bool,
    drawn_only: bool,
    workers: int | None,
    drive: str | None,
) -> Outcome:
    """Check the checks: faulty controllers must be caught, correct designs must pass.

    Each faulty controller has one known fault, and one check that is named for it; any of them is also a
    candidate of its own, as faulty:NAME. The exit code is 1 when a check misses its fault or a correct design
    is accused.
    """
    from drivegate.studies.selftest.selftest import chosen_mutations, selftested

    mutations = chosen_mutations(faults)

    from drivegate.drives.choice import drive_for
    from drivegate.studies.selftest.display import show_matrix
    from drivegate.studies.selftest.run import SelftestEffort

    amount = SelftestEffort(effort, seeds, workers, search, drawn_only, named_drive(drive))
    matrix = selftested(mutations, amount, designs=not faults and not drawn_only)
    code = ExitCode.PASSED if matrix.passed else ExitCode.FAILED
    document = matrix.document() | {"drive": drive_for(None, amount.drive).identity()}
    return Outcome(document, lambda console: show_matrix(console, matrix), code)
