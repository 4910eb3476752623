"""``drivegate selftest``: the checks checked, on controllers with known faults and on correct ones."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import WholeNumber, drive_option, json_option, named_drive, workers_option
from drivegate.output.failure import ExitCode

if TYPE_CHECKING:
    from drivegate_lab.selftest.drawn.run import DrivesRequest
    from drivegate_lab.selftest.run import SelftestEffort
    from drivegate_lab.selftest.unfair import DrawnDrives

ALL_SEEDS = 1000
MOST_DRIVES = 10_000
OUTPUT = Path("drivegate-selftest")
UNFAIR = Path("drivegate-unfair")
DRAWN = ("half-bridge", "star", "pm-ac")
"""Kinds of drives that are drawn, the default one first; named here since they take long to import."""


@click.command("selftest")
@click.option(
    "--fault",
    "faults",
    metavar="NAME",
    multiple=True,
    help="Only this faulty controller, and no correct designs; may be given again.",
)
@click.option(
    "--rare",
    is_flag=True,
    help="Only faulty controllers that operations show which are rarely tried, and no correct designs.",
)
@click.option(
    "--seeds",
    type=WholeNumber(1, ALL_SEEDS),
    default=1,
    show_default=True,
    help="Number of seeds of the search, from 0 on.",
)
@click.option(
    "--effort",
    type=click.Choice(["quick", "default", "nightly"]),
    help="Number of scenarios that are drawn; default, and quick with --drives.",
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
    "--unfair",
    is_flag=True,
    help="Search with every correct controller, for fair scenarios in which none of them meets a check.",
)
@workers_option
@click.option(
    "--drives",
    type=WholeNumber(1, MOST_DRIVES),
    metavar="N",
    help="Draw N drives, and see on how many of them the reference, or foc, passes.",
)
@click.option(
    "--kind",
    type=click.Choice(DRAWN),
    help="With --drives: kind of the drives that are drawn; half-bridge by default.",
)
@click.option("--drawing-seed", type=WholeNumber(0), help="Seed of the drawn drives; by default 0.")
@click.option(
    "--faults",
    "every_fault",
    is_flag=True,
    help="With --drives: every faulty controller too, on the drives that the reference passes.",
)
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    help="With --drives: folder of drives and results, by default drivegate-selftest; the same command goes on there. "
    "With --unfair: folder of the scenarios, by default drivegate-unfair.",
)
@drive_option
@json_option
def command(
    faults: tuple[str, ...],
    rare: bool,
    seeds: int,
    effort: str | None,
    search: bool,
    drawn_only: bool,
    unfair: bool,
    workers: int | None,
    drives: int | None,
    kind: str | None,
    drawing_seed: int | None,
    every_fault: bool,
    output: Path | None,
    drive: str | None,
) -> Outcome:
    """Check the checks: faulty controllers must be caught, correct designs must pass.

    Each faulty controller has one known fault, and one check that is named for it; any of them is also a
    candidate of its own, as faulty:NAME. The exit code is 1 when a check misses its fault or a correct design
    is accused.

    With --drives N the reference, on PM AC drives foc, is checked on N drives that are drawn within stated bounds,
    and the faulty controllers that --fault or --faults names on those that it passes. The exit code is 1 when it
    fails on any.

    With --unfair each correct controller is searched with as a candidate is, and the others are its witnesses. A
    failure that no witness avoids is a fault of the check or of what counts as fair: the exit code is 1, and the
    scenario is shrunk and kept. With --drives N it is done on N drawn drives.
    """
    if drives is None:
        given = {
            "--kind": kind is not None,
            "--drawing-seed": drawing_seed is not None,
            "--faults": every_fault,
            "--output": output is not None and not unfair,
        }
        _refuse(given, "goes with --drives N only")
    else:
        given = {
            "--drive": drive is not None,
            "--drawn-only": drawn_only,
            "--fault": bool(faults) and every_fault,
            "--rare": rare,
        }
        _refuse(given, f"does not go with {'--faults' if faults and every_fault else '--drives'}")
    given = {"--fault": bool(faults), "--faults": every_fault, "--rare": rare, "--drawn-only": drawn_only}
    _refuse({option: unfair and is_given for option, is_given in given.items()}, "does not go with --unfair")
    from drivegate_lab.selftest.run import chosen_names, selftested

    drawn_kind = kind or DRAWN[0]
    names = () if drives is None else chosen_names(faults, drawn_kind)

    from drivegate.drives.kinds import drive_for
    from drivegate_lab.selftest.display import show_matrix
    from drivegate_lab.selftest.drawn.run import DrivesRequest
    from drivegate_lab.selftest.run import SelftestEffort
    from drivegate_lab.selftest.unfair import DrawnDrives

    if drives is not None and unfair:
        amount = SelftestEffort(effort or "quick", seeds, workers, search)
        return _for_unfair(amount, output or UNFAIR, DrawnDrives(drawn_kind, drives, drawing_seed or 0))
    if drives is not None:
        named = names if faults or every_fault else ()
        request = DrivesRequest(
            drawn_kind,
            drives,
            drawing_seed or 0,
            named,
            SelftestEffort(effort or "quick", seeds, workers, search),
            output or OUTPUT,
        )
        return _on_drives(request)
    amount = SelftestEffort(effort or "default", seeds, workers, search, drawn_only, named_drive(drive))
    if unfair:
        return _for_unfair(amount, output or UNFAIR)
    if rare:
        from drivegate_lab.selftest.operations import proofs

        faults = (*faults, *proofs(drive_for(None, amount.drive)))
    matrix = selftested(faults, amount, designs=not faults and not drawn_only)
    code = ExitCode.PASSED if matrix.passed else ExitCode.FAILED
    document = matrix.document() | {"drive": drive_for(None, amount.drive).identity()}
    return Outcome(document, lambda console: show_matrix(console, matrix, drive), code)


def _on_drives(request: DrivesRequest) -> Outcome:
    from drivegate.output.progress import progress_on
    from drivegate_lab.selftest.drawn.display import show_drives
    from drivegate_lab.selftest.drawn.run import selftest_on_drives

    with progress_on(sys.stderr) as display:
        document = selftest_on_drives(request, display)
    code = ExitCode.PASSED if document["passed"] else ExitCode.FAILED
    return Outcome(document, lambda console: show_drives(console, document), code)


def _for_unfair(effort: SelftestEffort, output: Path, drives: DrawnDrives | None = None) -> Outcome:
    from drivegate.output.progress import progress_on
    from drivegate.output.report_folder import ReportFolder
    from drivegate_lab.selftest.display import show_unfair
    from drivegate_lab.selftest.unfair import keep_unfair, unfair_document, unfair_on_drives

    with ReportFolder(output) as folder, progress_on(sys.stderr) as display:
        document = (
            unfair_document(effort, display) if drives is None else unfair_on_drives(drives, effort, display)
        )
        kept = [output / name for name in keep_unfair(document, folder.staging)]
        # Those of an earlier search are no longer what was found.
        if kept or output.exists():
            folder.commit()
    code = ExitCode.PASSED if document["passed"] else ExitCode.FAILED
    return Outcome(document, lambda console: show_unfair(console, document, kept), code)


def _refuse(given: dict[str, bool], why: str) -> None:
    """Refuse the first option that has been given and does not fit."""
    for option in (option for option, is_given in given.items() if is_given):
        raise click.UsageError(f"{option} {why}")
