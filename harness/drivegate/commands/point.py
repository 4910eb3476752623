"""``drivegate point``: the steady state at one operating point."""

from __future__ import annotations

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import WholeNumber, bounded, chosen_drive, drive_options, json_option
from drivegate.drives.kinds import DEFAULT_DRIVE


@click.command("point")
@click.option("--speed-rpm", type=bounded(0.0, 1e5, above=True), required=True, help="Speed of the shaft.")
@click.option(
    "--advance-deg", type=bounded(0.0, 90.0), required=True, help="Advance angle, electrical degrees."
)
@click.option("--torque-nm", type=bounded(0.0, 1e6), help="Mean electromagnetic torque; finds the current.")
@click.option("--current-a", type=bounded(0.0, 1e5), help="Current reference.")
@click.option(
    "--cycles",
    type=WholeNumber(1, 100_000),
    help="Start with no current, run this many electrical cycles and average over the last.",
)
@drive_options
@json_option
def command(
    speed_rpm: float,
    advance_deg: float,
    torque_nm: float | None,
    current_a: float | None,
    cycles: int | None,
    drive: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compute the steady state at one operating point.

    Give the speed, the advance angle, and either the torque or the current reference.
    """
    if (torque_nm is None) == (current_a is None):
        raise click.UsageError("give exactly one of --torque-nm and --current-a")
    if cycles is not None and current_a is None:
        raise click.UsageError("--cycles goes with --current-a only")
    from drivegate.drives.kinds import require_angles
    from drivegate.studies.point import point_document, show_point
    from drivegate_cases.drive.drive_document import load_drive

    plant = require_angles(chosen_drive(drive, settings, lambda: load_drive(DEFAULT_DRIVE))).plant()
    document = point_document(
        plant, speed_rpm, advance_deg, torque_nm=torque_nm, current_a=current_a, cycles=cycles
    )
    return Outcome(document, lambda console: show_point(console, document, plant, torque_nm))
