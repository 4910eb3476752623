"""The figure of a counterexample that was run again: the decisive signals, and where the check was judged."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Final

from drivegate.output.legend import legend_beside
from drivegate.output.trace_files import write_plot
from drivegate.results.counterexample import Counterexample
from drivegate.studies.replay.replay import Replay, marked_angle
from drivegate.studies.simulate.simulate import trace_frame
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line
from drivegate_cases.scenario.script import Script

_PANELS: Final = (
    (("speed_reference_rpm", "reference"), ("speed_rpm", "speed"), "speed (rpm)"),
    (("current_sum_a", "Σ|i|"), None, "current (A)"),
)


def draw(stored: Counterexample, ended: Replay, plot: Path, title: str) -> None:
    """Draw what was observed, and set off what the check was judged on."""
    if isinstance(stored.scenario, Script):
        _draw_script(stored.scenario, ended, plot, title)
    elif ended.run is not None:
        frame = trace_frame(stored.scenario, ended.run)
        write_plot(frame, plot, title, shaded=ended.window, edge=marked_angle(stored, ended))


def _draw_script(script: Script, ended: Replay, plot: Path, title: str) -> None:
    """Draw what the controller sensed, row by row."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    edges = [number + 0.5 for number in range(len(script.rows) + 1)]
    buffer = io.BytesIO()
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        figure = Figure(figsize=(9.0, 6.0), layout="constrained")
        FigureCanvasAgg(figure)
        all_axes = figure.subplots(len(_PANELS), 1, sharex=True)
        for axes, (first, second, label) in zip(all_axes, _PANELS, strict=True):
            for key, name in (line for line in (first, second) if line is not None):
                axes.stairs([getattr(row, key) for row in script.rows], edges, baseline=None, label=name)
            if ended.rows is not None:
                axes.axvspan(
                    ended.rows[0] - 0.5,
                    ended.rows[1] + 0.5,
                    color="tab:orange",
                    alpha=0.15,
                    label="judged here",
                )
            axes.set_ylabel(label)
            axes.ticklabel_format(axis="y", useOffset=False)
            axes.grid(visible=True, alpha=0.3)
            legend_beside(axes)
        all_axes[-1].xaxis.get_major_locator().set_params(integer=True)
        all_axes[-1].set_xlabel("row: one period of the search")
        measured = ended.margin.measured if ended.margin is not None else ""
        figure.suptitle(one_line(f"{title}, {measured}"), fontsize="small", wrap=True)
        kind = plot.suffix.lower().removeprefix(".")
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())
