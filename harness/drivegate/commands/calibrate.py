"""``drivegate calibrate``: the motor derived anew from the published facts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.output.failure import ExitCode

if TYPE_CHECKING:
    from rich.console import Console


@click.command("calibrate")
@json_option
def command() -> Outcome:
    """Derive the motor anew from the published facts, and compare it with the stored one."""
    from drivegate.studies.calibrate.calibrate import calibration_document
    from drivegate_cases.drive.drive_document import load_drive

    stored = load_drive(DEFAULT_DRIVE)
    document = calibration_document(stored)
    code = ExitCode.PASSED if document["agrees"] else ExitCode.FAILED

    def show(console: Console) -> None:
        from drivegate.studies.calibrate.display import show_calibration

        show_calibration(console, document)

    return Outcome(document, show, code)
