"""``drivegate drive``: what a drive can do, before anyone is judged on it."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import chosen_drive, json_option, settings_option
from drivegate.drives.kinds import DEFAULT_DRIVE

if TYPE_CHECKING:
    from rich.console import Console


@click.command("drive")
@click.argument("drive", metavar="[NAME|FILE]", default=DEFAULT_DRIVE)
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@settings_option
@json_option
def command(drive: str, plot: Path | None, settings: tuple[str, ...]) -> Outcome:
    """Show what a drive can do: one that comes along, or a TOML or JSON file.

    Torque and power at the current limit over speed, the angles that give rated power and what they cost, the line of
    initial angles that follows, and what the drive's times mean for a controller. A rating that no controller can meet
    is named with the nearest that can be met.
    """
    from drivegate.output.trace_files import check_targets
    from drivegate_cases.drive.drive_document import load_drive

    check_targets(None, None, plot)
    chosen = chosen_drive(drive, settings, lambda: load_drive(DEFAULT_DRIVE))

    from drivegate.studies.drive.run import studied_drive

    document = studied_drive(chosen, plot=plot)

    def show(console: Console) -> None:
        from drivegate.studies.drive.display import show_drive

        show_drive(console, document, quote(drive))

    return Outcome(document, show)
