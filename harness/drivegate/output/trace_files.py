"""Writing a run's trace as CSV, Parquet or a figure; the target is looked at before the run."""

from __future__ import annotations

import io
import os
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.output.legend import legend_beside
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import pandas

PLOT_SUFFIXES: Final = (".png", ".svg")

_PANELS: Final = (
    (("speed_reference_rpm", "reference"), ("speed_rpm", "speed"), "speed (rpm)"),
    (("advance_deg", "advance angle"), None, "angle (el. deg)"),
    (("current_sum_a", "Σ|i|"), ("current_reference_a", "current reference"), "current (A)"),
    (("torque_nm", "torque"), ("load_torque_nm", "load"), "torque (N·m)"),
)
_DUTY_PANELS: Final = (
    (("speed_reference_rpm", "reference"), ("speed_rpm", "speed"), "speed (rpm)"),
    (("direct_current_a", "d"), ("quadrature_current_a", "q"), "current (A)"),
    (("voltage_v", "voltage used"), ("link_voltage_v", "link"), "voltage (V)"),
    (("torque_nm", "torque"), ("torque_reference_nm", "reference"), "torque (N·m)"),
)
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
    """Write a trace as the files that are requested."""
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
    *,
    shaded: tuple[float, float] | None = None,
    edge: tuple[float, float] | None = None,
) -> None:
    """Draw a trace: speed, angle, currents and torque over time, with the feasible edge from a time on (s, deg).

    Of a controller of duty ratios the currents of the rotor's frame and the voltage take the place of the angle.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    thinned = frame.iloc[:: -(-len(frame) // _MOST_POINTS)]
    buffer = io.BytesIO()
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        FigureCanvasAgg(figure)
        panels = _DUTY_PANELS if "direct_current_a" in frame else _PANELS
        all_axes = figure.subplots(len(panels), 1, sharex=True)
        for axes, (first, second, label) in zip(all_axes, panels, strict=True):
            for column, name in (line for line in (first, second) if line is not None):
                axes.plot(thinned["time_s"], thinned[column], label=name, linewidth=1.0)
            if edge is not None and first[0] == "advance_deg":
                begin, angle = edge
                reach = [begin, float(frame["time_s"].iloc[-1]) if shaded is None else shaded[1]]
                axes.plot(
                    reach, [angle] * 2, label="feasible edge", linewidth=1.2, linestyle="--", color="tab:red"
                )
            if shaded is not None:
                axes.axvspan(*shaded, color="tab:orange", alpha=0.15, label="judged here")
            axes.set_ylabel(label)
            axes.grid(visible=True, alpha=0.3)
            legend_beside(axes)
        all_axes[-1].set_xlabel("time (s)")
        figure.suptitle(one_line(title))
        kind = plot.suffix.lower().removeprefix(".")
        metadata = {"Date": None} if kind == "svg" else None
        figure.savefig(buffer, format=kind, dpi=120, metadata=metadata)
    write_atomically(plot, buffer.getvalue())
