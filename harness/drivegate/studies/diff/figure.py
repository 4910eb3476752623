"""The figure of the first difference between two candidates."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Final

import numpy as np

from drivegate.output.legend import legend_beside
from drivegate.studies.diff.diff import Difference
from drivegate.studies.diff.record import commands_of
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line
from drivegate_models.loop.given_steps import SCALARS

_PANELS: Final = (("current reference (A)", 0, 1.0), ("advance angle (el. deg)", 1, 180.0 / np.pi))


def draw(found: Difference, names: tuple[str, str], plot: Path, title: str) -> None:
    """Draw both commands around the first difference, their differences, and the speed."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer = io.BytesIO()
    kind = plot.suffix.lower().removeprefix(".")
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        FigureCanvasAgg(figure)
        all_axes = figure.subplots(2 * len(_PANELS) + 1, 1, sharex=True)
        _draw_panels(all_axes, found, names)
        for axes in all_axes:
            axes.axvline(found.step, color="tab:red", linewidth=1.0, linestyle=":")
            axes.grid(visible=True, alpha=0.3)
            axes.ticklabel_format(axis="both", useOffset=False)
        all_axes[-1].set_xlabel(f"step (dotted: step {found.step}, {found.sense.time:g} s)")
        figure.suptitle(one_line(title))
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())


def _draw_panels(all_axes: Any, found: Difference, names: tuple[str, str]) -> None:
    steps = found.begin + np.arange(len(found.rows))
    answered = steps[: len(found.answers)]
    first = commands_of(found.rows)
    for place, (label, column, unit) in enumerate(_PANELS):
        commands, apart = all_axes[2 * place], all_axes[2 * place + 1]
        commands.step(steps, first[:, column] * unit, where="post", label=one_line(names[0]))
        commands.step(
            answered,
            found.answers[:, column] * unit,
            where="post",
            label=one_line(names[1]),
            linestyle="--",
        )
        commands.set_ylabel(label)
        legend_beside(commands)
        difference = found.answers[:, column] - first[: len(answered), column]
        apart.step(answered, difference * unit, where="post", color="tab:red")
        apart.set_ylabel(f"difference{label[label.index(' (') :]}")
    speed = found.rows[:, SCALARS.index("speed")] * (30.0 / np.pi)
    all_axes[-1].plot(steps, speed, color="tab:gray")
    all_axes[-1].set_ylabel("speed sensed (rpm)")
