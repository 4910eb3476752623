"""``drivegate map``: an operating map of the plant, of the best that it can do, or of a candidate."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import chosen_motor, json_option, motor_options
from drivegate.drives.kinds import DEFAULT_MOTOR
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate.studies.map.map import OperatingMap
    from drivegate.studies.map.plan import MapPlan

SCHEMA = 1
_SPEEDS = {"points": "100:2000:39", "best": "550:2000:30", "loop": "550:2000:15"}
_TORQUES = {"best": "1:25:25", "loop": "2:24:12"}


@click.command("map")
@click.argument("candidate", required=False)
@click.option("--speed-rpm", metavar="AXIS", help="Speeds.")
@click.option("--torque-nm", metavar="AXIS", help="Torques: of the load with a candidate, else of the motor.")
@click.option("--advance-deg", metavar="AXIS", help="Advance angles of a map of the plant.")
@click.option("--current-a", metavar="AXIS", help="Current references of a map of the plant.")
@click.option(
    "--parameter",
    "parameters",
    metavar="KEY=AXIS",
    multiple=True,
    help="One more axis: a factor of the plant, or a key of the motor; may be given again.",
)
@click.option("--csv", type=click.Path(path_type=Path), help="Write the map as CSV.")
@click.option("--parquet", type=click.Path(path_type=Path), help="Write the map as Parquet.")
@click.option(
    "--plot", type=click.Path(path_type=Path), help="Write a figure; the name ends in .png or .svg."
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Processes; by default as many as there are processors."
)
@motor_options
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
    motor: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compute an operating map over a grid.

    An AXIS is LOW:HIGH:COUNT, a list such as 700,1000,1500, or a number.

    With CANDIDATE every point is a closed-loop run at a speed and a torque. Without, --torque-nm asks for the angle of
    least Σ|i| at every speed and torque; --advance-deg and --current-a ask for the steady state at every speed, angle
    and current.
    """
    kind = _kind(candidate, torque_nm, advance_deg, current_a)
    texts = {
        "speed_rpm": speed_rpm,
        "torque_nm": torque_nm,
        "advance_deg": advance_deg,
        "current_a": current_a,
    }
    axes = _axes(kind, texts)

    from drivegate.output.trace_files import check_targets

    check_targets(csv, parquet, plot)
    plan = _planned(kind, candidate, axes, parameters, motor, settings)

    from drivegate.containment.backend import Backend
    from drivegate.studies.campaign.progress import campaign_progress_on
    from drivegate.studies.map.files import write_figure, write_tables
    from drivegate.studies.map.map import computed

    _warm_up()
    began = time.monotonic()
    title = _title(plan)
    with campaign_progress_on(sys.stderr, title, plan.axes.points, unit="points") as tell:
        made = computed(plan, Backend("local", workers), tell)
    seconds = time.monotonic() - began
    write_tables(made, csv, parquet)
    if plot is not None:
        write_figure(made, plot, title)
    document = _document(made, seconds, [str(path) for path in (csv, parquet, plot) if path is not None])
    return Outcome(document, lambda console: _show(console, document, title))


def _kind(candidate: str | None, torque: str | None, advance: str | None, current: str | None) -> str:
    if candidate is None and torque is None:
        return "points"
    if advance is not None or current is not None:
        raise click.UsageError(
            "--advance-deg and --current-a go with a map of the plant, without a candidate and without --torque-nm"
        )
    return "best" if candidate is None else "loop"


def _axes(kind: str, texts: dict[str, str | None]) -> dict[str, tuple[float, ...]]:
    from drivegate.studies.map.axes import axis_within

    readers: dict[str, tuple[Callable[[str], tuple[float, ...]], str]] = {
        "speed_rpm": (axis_within(0.0, 1e5, above=True), _SPEEDS[kind])
    }
    if kind == "points":
        readers["advance_deg"] = (axis_within(0.0, 90.0), "0:90:46")
        readers["current_a"] = (axis_within(0.0, 1e5), "2:26:13")
    else:
        readers["torque_nm"] = (axis_within(0.0, 1e6, above=kind == "best"), _TORQUES[kind])
    axes = {}
    for name, (read, default) in readers.items():
        try:
            axes[name] = read(texts[name] or default)
        except InputError as error:
            raise InputError(f"--{name.replace('_', '-')}: {error}") from error
    return axes


def _planned(
    kind: str,
    candidate: str | None,
    axes: dict[str, tuple[float, ...]],
    parameters: tuple[str, ...],
    motor: str | None,
    settings: tuple[str, ...],
) -> MapPlan:
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate_cases.motor.motor import load_motor

    resolved = None if candidate is None else resolve_candidate(candidate)
    nominal = chosen_motor(motor, settings, lambda: load_motor(DEFAULT_MOTOR))

    from drivegate.studies.map.axes import MapAxes, parameter_axis
    from drivegate.studies.map.plan import PARAMETERS, MapPlan

    further = dict(parameter_axis(text, PARAMETERS) for text in parameters)
    if len(further) < len(parameters):
        raise InputError("--parameter names the same key twice, but each key has one axis")
    # Parameters vary slowest, so that each worker's points share one drive.
    return MapPlan(kind, nominal, MapAxes.of({**further, **axes}), resolved)


def _warm_up() -> None:
    from drivegate.gate.warm_up import compile_kernels, missing_marker

    marker = missing_marker()
    if marker is not None:
        compile_kernels(marker)


def _title(plan: MapPlan) -> str:
    if plan.candidate is not None:
        return f"{plan.candidate.name} on {plan.motor.name}"
    return plan.motor.name if plan.kind == "points" else f"the best of {plan.motor.name}"


def _document(made: OperatingMap, seconds: float, files: list[str]) -> dict[str, Any]:
    import numpy as np

    plan = made.plan
    finite = np.isfinite(made.numbers)
    ranges = {
        name: {"lowest": float(column[here].min()), "highest": float(column[here].max())}
        for name, column, here in zip(plan.columns, made.numbers.T, finite.T, strict=True)
        if here.any() and name != "certified"
    }
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "operating map",
        "of": plan.kind,
        "motor": plan.motor.name,
        "candidate": None if plan.candidate is None else plan.candidate.name,
        "axes": {name: list(values) for name, values in zip(plan.axes.names, plan.axes.values, strict=True)},
        "points": plan.axes.points,
        "without_values": int(np.count_nonzero(~finite.any(axis=1))),
        "ranges": ranges,
        "verdicts": {verdict: made.verdicts.count(verdict) for verdict in sorted(set(made.verdicts))},
    }
    if plan.kind == "points":
        document["not_certified"] = int(np.count_nonzero(made.numbers[:, -1] == 0.0))
    return document | {"files": files, "timing": {"seconds": seconds}}


def _show(console: Console, document: dict[str, Any], title: str) -> None:
    from drivegate.output.console import number, plain, table

    listed = table(
        "quantity",
        "lowest",
        "highest",
        right=("lowest", "highest"),
        title=f"{title}: {document['points']} points",
    )
    for name, span in document["ranges"].items():
        listed.add_row(name, number(span["lowest"]), number(span["highest"]))
    console.print(listed)
    if document["verdicts"]:
        console.print(
            plain(", ".join(f"{count} {verdict}" for verdict, count in document["verdicts"].items()))
        )
    elif document["without_values"]:
        console.print(plain(f"{document['without_values']} points are out of reach and have no values"))
    if document.get("not_certified"):
        console.print(
            plain(
                f"{document['not_certified']} points have no periodic state; their means are over many cycles"
            )
        )
    seconds = document["timing"]["seconds"]
    console.print(plain(f"{document['points'] / max(seconds, 1e-9):.3g} points a second", "dim"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if not document["files"]:
        console.print(plain("next: the same with --plot map.png and --parquet map.parquet", "dim"))
