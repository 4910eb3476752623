"""Marks of every candidate at the rows of a table, by speed and load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pandas as pd

from drivegate.contracts.comparison import POINTS
from drivegate.contracts.drawings import RowMarks, column_of
from drivegate_reports.comparison.cells import written
from drivegate_reports.comparison.inks import Ink
from drivegate_reports.page.style import GREY, VERMILION, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DASHED: Final = (0, (4, 3))
_APART: Final = 0.7
_MOST_TICKS: Final = 60
"""Loads that are named below the panels, which are legible beside each other."""
_MOST_LEVEL_TICKS: Final = 12
_MOST_LEVEL: Final = 6
"""Speeds that have room above the panels without being turned."""


def marked_rows(document: Mapping[str, Any], drawing: RowMarks) -> pd.DataFrame:
    """Return the rows that are drawn, of operating points those that are held, by candidate, speed and load."""
    rows = [row for row in document["tables"][drawing.table] if drawing.table != POINTS or row["held"]]
    table = pd.DataFrame(rows)
    return table.set_index(["candidate", "speed_rpm", drawing.load], drop=False) if rows else table


def draw_marks(document: Mapping[str, Any], drawing: RowMarks, inks: Mapping[str, Ink]) -> Figure:
    """Draw a mark for each candidate at each place, in a panel for each quantity."""
    rows, panels = marked_rows(document, drawing), drawing.panels
    places = sorted({(row["speed_rpm"], row[drawing.load]) for row in document["tables"][drawing.table]})
    figure, axes = new_figure(1.1 + 1.25 * len(panels), len(panels))
    shifts = np.linspace(-0.5, 0.5, len(inks) + 2)[1:-1] * _APART
    for axis, panel in zip(axes, panels, strict=True):
        known = column_of(rows, panel.values).dropna().to_dict()
        for (candidate, ink), shift in zip(inks.items(), shifts, strict=True):
            marks = [
                (x + shift, known[candidate, *place])
                for x, place in enumerate(places)
                if (candidate, *place) in known
            ]
            if marks:
                axis.plot(
                    *zip(*marks, strict=True), ink.marker, color=ink.colour, markersize=4.5, label=ink.label
                )
        if panel.limit is not None:
            axis.axhline(panel.limit(document), color=VERMILION, linewidth=1.1, linestyle=_DASHED)
        axis.set_ylabel(panel.label)
        axis.set_ylim(bottom=min(0.0, axis.get_ylim()[0]))
        _mark_speeds(axis, places)
    _name_speeds(axes[0], places)
    for axis in axes[:-1]:
        axis.tick_params(labelbottom=False)
    turned = 90 if len(places) > _MOST_LEVEL_TICKS else 0
    every = -(-len(places) // _MOST_TICKS)
    shown = range(0, len(places), every)
    size = 7.5 if turned else 9.0
    axes[-1].set_xticks(shown, [f"{places[x][1]:.3g}" for x in shown], rotation=turned, fontsize=size)
    axes[-1].set_xlabel(drawing.load_label)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=9.0)
    return figure


def _groups(places: Sequence[tuple[float, float]]) -> list[tuple[float, int, int]]:
    """Return each speed with its first and its last place."""
    found, begin = [], 0
    for speed, members in groupby(places, key=lambda place: place[0]):
        end = begin + len(list(members))
        found.append((speed, begin, end - 1))
        begin = end
    return found


def _mark_speeds(axis: Axes, places: Sequence[tuple[float, float]]) -> None:
    axis.set_xlim(-0.5, len(places) - 0.5)
    axis.set_xticks(range(len(places)))
    axis.grid(visible=False, axis="x")
    for _, begin, _ in _groups(places)[1:]:
        axis.axvline(begin - 0.5, color=GREY, linewidth=0.8)


def _name_speeds(axis: Axes, places: Sequence[tuple[float, float]]) -> None:
    """Name each speed above its places; where they are narrow, turned and with one unit for all."""
    groups = _groups(places)
    is_narrow = len(groups) > _MOST_LEVEL
    for number, (speed, begin, end) in enumerate(groups):
        axis.annotate(
            f"{speed:g}{'' if is_narrow and number else ' rpm'}",
            (0.5 * (begin + end), 1.03),
            xycoords=("data", "axes fraction"),
            ha="left" if is_narrow else "center",
            va="bottom",
            rotation=60 if is_narrow else 0,
            fontsize=9.0,
        )


def marks_in_words(document: Mapping[str, Any], drawing: RowMarks, inks: Mapping[str, Ink]) -> str:
    """Describe a figure in words, for who cannot see it."""
    rows, described = marked_rows(document, drawing), []
    for candidate, ink in inks.items():
        own, ranges = rows[rows["candidate"] == candidate], []
        for panel in drawing.panels:
            values = column_of(own, panel.values).dropna()
            if len(values):
                name = panel.label.replace("\n", " ")
                ranges.append(f"{name} from {written(values.min(), 2)} to {written(values.max(), 2)}")
        described.append(f"{ink.label}: {'; '.join(ranges) or 'nothing'}.")
    return " ".join(described)
