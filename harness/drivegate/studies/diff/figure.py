"""The figure of the first difference between two candidates."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from drivegate.contracts.contract import Contract
from drivegate.output.legend import legend_beside
from drivegate.studies.diff.diff import Difference
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line
from drivegate_models.units import RPM


def draw(found: Difference, contract: Contract, names: tuple[str, str], plot: Path, title: str) -> None:
    """Draw both commands around the first difference, their differences, and the speed."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer = io.BytesIO()
    kind = plot.suffix.lower().removeprefix(".")
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        rows = 2 * len(contract.plotted) + 1
        figure = Figure(figsize=(9.0, 1.8 * rows), layout="constrained")
        FigureCanvasAgg(figure)
        all_axes = figure.subplots(rows, 1, sharex=True)
        _draw_panels(all_axes, found, contract, names)
        for axes in all_axes:
            axes.axvline(found.step, color="tab:red", linewidth=1.0, linestyle=":")
            axes.grid(visible=True, alpha=0.3)
            axes.ticklabel_format(axis="both", useOffset=False)
        time = found.rows["sense"]["time"][found.step - found.begin]
        all_axes[-1].set_xlabel(f"step (dotted: step {found.step}, {time:g} s)")
        figure.suptitle(one_line(title))
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())


def _draw_panels(all_axes: Any, found: Difference, contract: Contract, names: tuple[str, str]) -> None:
    steps = found.begin + np.arange(len(found.rows))
    answered = steps[: len(found.answers)]
    for place, (field, (unit, factor)) in enumerate(contract.plotted.items()):
        first, second = found.rows["command"][field] * factor, found.answers[field] * factor
        commands, apart = all_axes[2 * place], all_axes[2 * place + 1]
        commands.step(steps, first, where="post", label=one_line(names[0]))
        commands.step(answered, second, where="post", label=one_line(names[1]), linestyle="--")
        commands.set_ylabel(f"{contract.outputs[field][0]} ({unit})")
        legend_beside(commands)
        apart.step(answered, second - first[: len(second)], where="post", color="tab:red")
        apart.set_ylabel(f"difference ({unit})")
    all_axes[-1].plot(steps, found.rows["sense"]["speed"] * RPM, color="tab:gray")
    all_axes[-1].set_ylabel("speed sensed (rpm)")
