"""``drivegate drive``: what a drive can do, before anyone is judged on it."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

import click

from drivegate.commands.completion import complete_drive
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import chosen_drive, json_option, settings_option
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.output.failure import ExitCode


@click.command("drive")
@click.argument("drive", metavar="[NAME|FILE]", default=DEFAULT_DRIVE, shell_complete=complete_drive)
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@click.option(
    "--fit",
    "measured",
    type=click.Path(path_type=Path),
    metavar="FILE.csv",
    help="Fit EMF constant, inductance, resistance and flat width to torques: speed_rpm, torque_nm, and advance_deg, "
    "current_a, uncertainty_nm where known.",
)
@click.option(
    "--keep", metavar="KEY", multiple=True, help="Leave one constant out of the fit; may be given again."
)
@settings_option
@json_option
def command(
    drive: str, plot: Path | None, measured: Path | None, keep: tuple[str, ...], settings: tuple[str, ...]
) -> Outcome:
    """Show what a drive can do: one that is included, or a TOML or JSON file.

    Torque and power at the current limit over speed, the angles that give rated power and what they cost, the line of
    initial angles that follows, and what the drive's times mean for a controller. What a check
    refuses of the drive is printed with the value that it accepts, and the exit code is then 2 as well.

    With --fit it shows instead which constants explain measured or published torques, with the uncertainty of each. The
    exit code is 2 if none do, or if the points do not determine all of them.
    """
    if keep and measured is None:
        raise click.UsageError("--keep goes with --fit only")
    if plot is not None and measured is not None:
        raise click.UsageError(
            "--plot and --fit do not go together; draw the drive with the fitted constants"
        )
    from drivegate.output.trace_files import check_targets
    from drivegate_cases.drive.drive_document import load_drive

    check_targets(None, None, plot)
    chosen = chosen_drive(drive, settings, lambda: load_drive(DEFAULT_DRIVE))
    if measured is not None:
        from drivegate.studies.drive.display import show_fit
        from drivegate.studies.drive.run import fitted_drive

        fit = fitted_drive(chosen, measured, keep)
        code = ExitCode.PASSED if fit["usable"] else ExitCode.REFUSED
        return Outcome(fit, lambda console: show_fit(console, fit, quote(drive)), code)

    from drivegate.studies.drive.display import show_drive
    from drivegate.studies.drive.run import studied_drive

    document = studied_drive(chosen, plot=plot)
    code = ExitCode.REFUSED if document["unreachable"] else ExitCode.PASSED
    return Outcome(document, lambda console: show_drive(console, document, quote(drive), chosen), code)
