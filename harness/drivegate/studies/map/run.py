"""An operating map from its plan to its files, its document and the console, with progress."""

from __future__ import annotations

import io
import pickle
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from drivegate.containment.backend import Backend, done_by
from drivegate.gate.warm_up import compile_missing
from drivegate.output.console import number, print_ending, print_line, table
from drivegate.output.figures import figure_file
from drivegate.output.progress import progress_on, with_rate
from drivegate.studies.map.plan import ADVANCE, CURRENT, PARAMETERS, SPEED, TORQUE, MapPlan, plant_of
from drivegate.studies.map.tasks import compile_solver, compute_piece
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PANELS: Final = {
    "points": (
        ("torque_mean_nm", "torque (N·m)"),
        ("current_sum_a", "Σ|i| (A)"),
        ("torque_ripple_percent", "torque ripple (%)"),
        ("input_power_w", "input power (W)"),
    ),
    "best": (
        ("advance_deg", "angle of least Σ|i| (el. deg)"),
        ("edge_deg", "smallest feasible angle (el. deg)"),
        ("current_sum_a", "least Σ|i| (A)"),
        ("efficiency", "efficiency (1)"),
    ),
    "loop": (
        ("advance_deg", "advance angle (el. deg)"),
        ("excess_percent", "Σ|i| above the least (%)"),
        ("convergence_margin", "margin of convergence (1)"),
        ("efficiency", "efficiency (1)"),
    ),
}
_RIPPLE_SHOWN: Final = 50.0
_NAMES: Final = {SPEED: "speed (rpm)", TORQUE: "torque (N·m)", ADVANCE: "advance angle (el. deg)"}
_SCHEMA: Final = 1


@dataclass(frozen=True)
class OperatingMap:
    """A finished map."""

    plan: MapPlan
    numbers: NDArray[np.float64]
    """What was computed, shape (points, columns)."""
    verdicts: list[str] = field(default_factory=list)
    """What became of each closed-loop run; empty of other maps."""

    def table(self) -> dict[str, Any]:
        columns: dict[str, Any] = dict(self.plan.axes.coordinates(0, self.plan.axes.points))
        if self.verdicts:
            columns["verdict"] = self.verdicts
        for place, name in enumerate(self.plan.columns):
            columns[f"found_{name}" if name in columns else name] = self.numbers[:, place]
        if "certified" in columns:
            columns["certified"] = columns["certified"] != 0.0
        return columns


def computed(plan: MapPlan, backend: Backend, report_progress: Callable[[int, int], None]) -> OperatingMap:
    # A value that the plant cannot have is refused before anything is computed.
    for name, parameter_values in zip(plan.axes.names, plan.axes.values, strict=True):
        for value in parameter_values if name in PARAMETERS else ():
            plant_of(plan.drive, {name: value})
    points, done = plan.axes.points, 0
    values = np.full((points, len(plan.columns)), nan)
    verdicts = [""] * points if plan.kind == "loop" else []
    package = pickle.dumps(plan, pickle.HIGHEST_PROTOCOL)
    if plan.kind == "points":
        compile_solver(package, plan.drive.kind)
    report_progress(0, 0)
    for (first, last), part in done_by(backend, compute_piece, package, plan.pieces()):
        values[first:last] = part.values
        if part.verdicts:
            verdicts[first:last] = part.verdicts
        done += last - first
        report_progress(done, 0)
    return OperatingMap(plan, values, verdicts)


def made_map(
    plan: MapPlan, workers: int | None, *, csv: Path | None, parquet: Path | None, plot: Path | None
) -> tuple[dict[str, Any], str]:
    """Compute a map and write its files; return its document and its title."""
    compile_missing([plan.drive])
    began = time.monotonic()
    title = plan.drive.name if plan.kind == "points" else f"the best of {plan.drive.name}"
    if plan.candidate is not None:
        title = f"{plan.candidate.name} on {plan.drive.name}"
    with progress_on(sys.stderr) as display:
        report_progress = with_rate(display, title, plan.axes.points, unit="points")
        made = computed(plan, Backend("local", workers), report_progress)
    seconds = time.monotonic() - began
    _write_tables(made, csv, parquet)
    if plot is not None:
        _write_figure(made, plot, title)
    written = [str(path) for path in (csv, parquet, plot) if path is not None]
    return _document_of(made, seconds, written), title


def _document_of(made: OperatingMap, seconds: float, files: Sequence[str]) -> dict[str, Any]:
    """Return the ranges of what was computed, and the files that it was written into."""
    plan = made.plan
    finite = np.isfinite(made.numbers)
    ranges = {
        name: {"lowest": float(column[here].min()), "highest": float(column[here].max())}
        for name, column, here in zip(plan.columns, made.numbers.T, finite.T, strict=True)
        if here.any() and name != "certified"
    }
    document: dict[str, Any] = {
        "schema": _SCHEMA,
        "kind": "operating map",
        "of": plan.kind,
        "drive": plan.drive.identity(),
        "candidate": None if plan.candidate is None else plan.candidate.name,
        "axes": {name: list(values) for name, values in zip(plan.axes.names, plan.axes.values, strict=True)},
        "points": plan.axes.points,
        "without_values": int(np.count_nonzero(~finite.any(axis=1))),
        "ranges": ranges,
        "verdicts": {verdict: made.verdicts.count(verdict) for verdict in sorted(set(made.verdicts))},
    }
    if plan.kind == "points":
        document["not_certified"] = int(np.count_nonzero(made.numbers[:, -1] == 0.0))
    return document | {"files": list(files), "timing": {"seconds": seconds}}


def _write_tables(made: OperatingMap, csv: Path | None, parquet: Path | None) -> None:
    if csv is None and parquet is None:
        return
    columns = made.table()
    if parquet is not None:
        import pyarrow
        from pyarrow import parquet as writer

        buffer = io.BytesIO()
        writer.write_table(pyarrow.table(columns), buffer, compression="zstd", compression_level=3)
        write_atomically(parquet, buffer.getvalue())
    if csv is not None:
        import pandas

        write_atomically(csv, pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))


def _write_figure(made: OperatingMap, plot: Path, title: str) -> None:
    """Draw a map: four quantities over speed and torque, or over speed and angle."""
    other = ADVANCE if made.plan.kind == "points" else TORQUE
    chosen, fixed_values = _slice(made, other)
    with figure_file(plot, 11.0, 8.0) as figure:
        for axes, (column, label) in zip(figure.subplots(2, 2).flat, _PANELS[made.plan.kind], strict=True):
            values = chosen[made.plan.columns.index(column)]
            if column == "torque_ripple_percent":
                # Beside no torque any ripple is endless, and would leave no colour for the rest.
                values = np.where(values > _RIPPLE_SHOWN, np.nan, values)
            _draw(axes, made, other, values, label)
        figure.suptitle(one_line(f"{title}{fixed_values}"))


def _slice(made: OperatingMap, other: str) -> tuple[NDArray[np.float64], str]:
    """Take the columns over speed and the other axis, at the greatest current and the first of other values."""
    axes = made.plan.axes
    cube = made.numbers.reshape(*axes.shape, -1)
    places: list[Any] = []
    fixed_values = ""
    for name, values in zip(axes.names, axes.values, strict=True):
        if name in (SPEED, other):
            places.append(slice(None))
            continue
        place = len(values) - 1 if name == CURRENT else 0
        places.append(place)
        fixed_values += f", {name} = {values[place]:g}"
    return np.moveaxis(cube[tuple(places)], -1, 0), fixed_values


def _draw(axes: Axes, made: OperatingMap, other: str, values: NDArray[np.float64], label: str) -> None:
    of = dict(zip(made.plan.axes.names, made.plan.axes.values, strict=True))
    axes.set_title(label, fontsize="medium")
    if len(of[SPEED]) == 1 or len(of[other]) == 1:
        along = other if len(of[SPEED]) == 1 else SPEED
        axes.plot(of[along], values.ravel(), marker=".", linewidth=1.0)
        axes.set_xlabel(_NAMES[along])
        axes.grid(visible=True, alpha=0.3)
        return
    shown = np.ma.masked_invalid(values.T)
    mesh = axes.pcolormesh(of[SPEED], of[other], shown, shading="nearest", rasterized=True)
    if axes.figure is not None:
        axes.figure.colorbar(mesh, ax=axes)
    axes.set_xlabel(_NAMES[SPEED])
    axes.set_ylabel(_NAMES[other])


def show_map(console: Console, document: dict[str, Any], title: str) -> None:
    """Print the ranges of a map and the files of it."""
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
        print_line(
            console, ", ".join(f"{count} {verdict}" for verdict, count in document["verdicts"].items())
        )
    elif document["without_values"]:
        print_line(console, f"{document['without_values']} points are out of reach and have no values")
    if document.get("not_certified"):
        print_line(
            console,
            f"{document['not_certified']} points have no periodic state; their means are over many cycles",
        )
    seconds = document["timing"]["seconds"]
    print_line(console, f"{document['points'] / max(seconds, 1e-9):.3g} points a second", "dim")
    hint = "" if document["files"] else "the same with --plot map.png and --parquet map.parquet"
    print_ending(console, document["files"], hint)
