"""Writing a run's trace as CSV, Parquet or a figure; the target is looked at before the run."""

from __future__ import annotations

import io
import os
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.contracts.drawings import TIME, Panel, panels_for
from drivegate.output.figures import figure_file, side_legend
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import FigureBase

    from drivegate.checks.margin import Moment

PLOT_SUFFIXES: Final = (".png", ".svg")

_MOST_POINTS: Final = 20_000


def check_targets(csv: Path | None, parquet: Path | None, plot: Path | None) -> None:
    """Refuse what could not be written after the run."""
    targets = [target for target in (csv, parquet, plot) if target is not None]
    for target in targets:
        check_writable(target)
    if len({target.resolve() for target in targets}) < len(targets):
        raise InputError(
            "two of --csv, --parquet and --plot name the same file, but each needs one of its own"
        )
    if plot is not None and plot.suffix.lower() not in PLOT_SUFFIXES:
        raise InputError(
            f"--plot {shown_path(plot)}: the name ends in '{one_line(plot.suffix)}', but must end in .png or .svg"
        )
    if parquet is not None and find_spec("pyarrow") is None:
        raise InputError(
            "--parquet needs the package pyarrow, which is not installed; pip install pyarrow, or take --csv"
        )


def check_writable(path: Path) -> None:
    """Refuse a file that cannot be written at its place."""
    try:
        target = path.resolve()
        if target.is_dir():
            problem = "is a folder; name a file"
        elif not target.parent.is_dir():
            problem = "cannot be written, since its folder does not exist; name a file in an existing folder"
        elif not os.access(target.parent, os.W_OK | os.X_OK):
            problem = "cannot be written, since its folder is not writable; name a file in a writable folder"
        elif target.exists() and not target.is_file():
            problem = "is not a regular file; name one"
        else:
            return
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{shown_path(path)} cannot be written: {one_line(reason)}; name another file"
        ) from error
    raise InputError(f"{shown_path(path)} {problem}")


def write_trace(frame: pandas.DataFrame, csv: Path | None, parquet: Path | None) -> None:
    if csv is not None:
        write_atomically(csv, frame.to_csv(index=False, lineterminator="\n"))
    if parquet is not None:
        buffer = io.BytesIO()
        frame.to_parquet(buffer, engine="pyarrow", index=False)
        write_atomically(parquet, buffer.getvalue())


def write_plot(
    frame: pandas.DataFrame,
    plot: Path,
    title: str,
    panels: tuple[Panel, ...],
    *,
    moment: Moment | None = None,
    edge: tuple[float, float] | None = None,
) -> None:
    """Draw a trace over time, with the feasible edge from a time on (s, deg); above it the moment that decides."""
    from drivegate.output.panels import draw_moment

    thinned = frame.iloc[:: -(-len(frame) // _MOST_POINTS)]
    shown = panels_for(panels, frame.columns)
    is_marked = moment is not None and moment.is_marked
    with figure_file(plot, 9.0, 12.0 if is_marked else 9.0) as figure:
        whole: FigureBase = figure
        if moment is not None and is_marked:
            parts = figure.subfigures(2, 1, squeeze=False, height_ratios=(1, 3))[:, 0]
            whole = parts[1]
            columns = {name: frame[name].to_numpy() for name in (TIME, moment.column) if name}
            draw_moment(parts[0].subplots(), moment, columns, panels)
        all_axes = whole.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (label, lines) in zip(all_axes, shown, strict=True):
            for line in lines:
                style = "--" if line.is_reference else ":" if line.is_sensed else "-"
                axes.plot(
                    thinned[TIME], thinned[line.column], label=line.name, linewidth=1.0, linestyle=style
                )
            if edge is not None and lines[0].column == "advance_deg":
                begin, angle = edge
                reach = [begin, float(frame[TIME].iloc[-1]) if moment is None else moment.end_s]
                axes.plot(
                    reach, [angle] * 2, label="feasible edge", linewidth=1.2, linestyle="--", color="tab:red"
                )
            if moment is not None:
                axes.axvspan(
                    moment.start_s, moment.end_s, color="tab:orange", alpha=0.15, label="judged here"
                )
            axes.set_ylabel(label)
            axes.grid(visible=True, alpha=0.3)
            side_legend(axes)
        all_axes[-1].set_xlabel("time (s)")
        figure.suptitle(one_line(title))
