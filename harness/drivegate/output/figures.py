"""Figures as files, and their legends, which hide no trace."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate_cases.documents.atomic_write import write_atomically

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@contextmanager
def figure_file(plot: Path, width: float, height: float) -> Iterator[Figure]:
    """Make a figure of a size (inch) to draw on, and write it as PNG or SVG when the context ends without an error.

    The same drawing gives the same bytes: an SVG has no date, and a fixed salt for its identifiers.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer = io.BytesIO()
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        kind = plot.suffix.lower().removeprefix(".")
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())


def side_legend(axes: Axes) -> None:
    """Put the legend to the right of a panel; to be used where the layout is constrained."""
    axes.legend(
        loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, frameon=False, fontsize="small"
    )
