"""The figure of the first difference between two candidates."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.output.legend import legend_beside
from drivegate.studies.diff.diff import Difference
from drivegate.studies.diff.record import commands_of
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line
from drivegate_models.loop.given_steps import SCALARS
from drivegate_models.units import RPM

_PANELS: Final = (("current reference (A)", 0, 1.0), ("advance angle (el. deg)", 1, 180.0 / np.pi))


@dataclass(frozen=True)
class DrawnSteps:
    """Commands of both candidates around the first difference."""

    step: int
    begin: int
    """Number of the step that differs first, and of the first that is drawn."""
    time_s: float
    """Time of the one that differs (s)."""
    panels: tuple[tuple[str, NDArray[np.float64], NDArray[np.float64]], ...]
    """Name with unit, commands of the first candidate, and of the second, which may be fewer."""
    speed_rpm: NDArray[np.float64]
    """Speed that was sensed (rpm), shape (n,)."""


def drawn_steps(found: Difference) -> DrawnSteps:
    """Take what is drawn from a difference of current references or advance angles."""
    first = commands_of(found.rows)
    return DrawnSteps(
        found.step,
        found.begin,
        found.sense.time,
        tuple(
            (label, first[:, column] * unit, found.answers[:, column] * unit)
            for label, column, unit in _PANELS
        ),
        found.rows[:, SCALARS.index("speed")] * RPM,
    )


def draw(drawn: DrawnSteps, names: tuple[str, str], plot: Path, title: str) -> None:
    """Draw both commands around the first difference, their differences, and the speed."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer = io.BytesIO()
    kind = plot.suffix.lower().removeprefix(".")
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        rows = 2 * len(drawn.panels) + 1
        figure = Figure(figsize=(9.0, 1.8 * rows), layout="constrained")
        FigureCanvasAgg(figure)
        all_axes = figure.subplots(rows, 1, sharex=True)
        _draw_panels(all_axes, drawn, names)
        for axes in all_axes:
            axes.axvline(drawn.step, color="tab:red", linewidth=1.0, linestyle=":")
            axes.grid(visible=True, alpha=0.3)
            axes.ticklabel_format(axis="both", useOffset=False)
        all_axes[-1].set_xlabel(f"step (dotted: step {drawn.step}, {drawn.time_s:g} s)")
        figure.suptitle(one_line(title))
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())


def _draw_panels(all_axes: Any, drawn: DrawnSteps, names: tuple[str, str]) -> None:
    steps = drawn.begin + np.arange(len(drawn.speed_rpm))
    for place, (label, first, second) in enumerate(drawn.panels):
        commands, apart = all_axes[2 * place], all_axes[2 * place + 1]
        answered = steps[: len(second)]
        commands.step(steps, first, where="post", label=one_line(names[0]))
        commands.step(answered, second, where="post", label=one_line(names[1]), linestyle="--")
        commands.set_ylabel(label)
        legend_beside(commands)
        apart.step(answered, second - first[: len(second)], where="post", color="tab:red")
        apart.set_ylabel(f"difference{label[label.index(' (') :]}")
    all_axes[-1].plot(steps, drawn.speed_rpm, color="tab:gray")
    all_axes[-1].set_ylabel("speed sensed (rpm)")
