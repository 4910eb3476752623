"""``drivegate map``: an operating map of the plant, of the best that it can do, or of a candidate."""

from __future__ import annotations

from pathlib import Path

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import chosen_drive, drive_options, json_option, workers_option


@click.command("map")
@click.argument("candidate", required=False)
@click.option("--speed-rpm", metavar="AXIS", help="Speeds.")
@click.option("--torque-nm", metavar="AXIS", help="Torques: of the load with a candidate, else of the drive.")
@click.option("--advance-deg", metavar="AXIS", help="Advance angles of a map of the plant.")
@click.option("--current-a", metavar="AXIS", help="Current references of a map of the plant.")
@click.option(
    "--parameter",
    "parameters",
    metavar="KEY=AXIS",
    multiple=True,
    help="One more axis: a factor of the plant, or a key of the drive; may be given again.",
)
@click.option("--csv", type=click.Path(path_type=Path), help="Write the map as CSV.")
@click.option("--parquet", type=click.Path(path_type=Path), help="Write the map as Parquet.")
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@workers_option
@drive_options
@json_option
def command(
    candidate: str | None,
    speed_rpm: str | None,
    torque_nm: str | None,
    advance_deg: str | None,
    current_a: str | None,
    parameters: tuple[str, ...],
    csv: Path | None,
    parquet: Path | None,
    plot: Path | None,
    workers: int | None,
    drive: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compute an operating map over a grid.

    An AXIS is LOW:HIGH:COUNT, a list such as 700,1000,1500, or a number.

    With CANDIDATE every point is a closed-loop run at a speed and a torque. Without, --torque-nm requests the angle of
    least Σ|i| at every speed and torque; --advance-deg and --current-a request the steady state at every speed, angle
    and current.
    """
    from drivegate.studies.map.plan import map_axes, map_kind, planned_map

    texts = {
        "speed_rpm": speed_rpm,
        "torque_nm": torque_nm,
        "advance_deg": advance_deg,
        "current_a": current_a,
    }
    kind = map_kind(candidate, texts)
    axes = map_axes(kind, texts)

    from drivegate.output.trace_files import check_targets

    check_targets(csv, parquet, plot)

    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.drives.kinds import drive_for, require_angles

    resolved = None if candidate is None else resolve_candidate(candidate)
    nominal = require_angles(chosen_drive(drive, settings, lambda: drive_for(resolved)))
    plan = planned_map(kind, nominal, resolved, axes, parameters)

    from drivegate.studies.map.run import made_map, show_map

    document, title = made_map(plan, workers, csv=csv, parquet=parquet, plot=plot)
    return Outcome(document, lambda console: show_map(console, document, title))
