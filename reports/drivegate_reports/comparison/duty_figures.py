"""Figures of a comparison of controllers of duty ratios: steady states over the best possible, and steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate_reports.comparison.cells import written
from drivegate_reports.comparison.inks import Ink, inks_of
from drivegate_reports.page.figure import PageFigure
from drivegate_reports.page.style import GREY, VERMILION, house_style, inline_svg, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = Mapping[str, Any]

_DASHED: Final = (0, (4, 3))
_APART: Final = 0.7


@dataclass(frozen=True)
class Panel:
    """What a panel shows."""

    label: str
    """Its axis."""
    key: str
    """The quantity in the rows."""
    limit: float | None = None
    """A limit to be drawn."""


POINT_PANELS: Final = (
    Panel("loss above\nleast (%)", "loss_above_least_percent"),
    Panel("current above\nleast (%)", "current_above_least_percent"),
    Panel("ripple (% of\nrated torque)", "ripple_percent"),
)
"""Panels of the operating points."""


def duty_figures(document: Mapping[str, Any]) -> tuple[PageFigure, ...]:
    """Draw everything."""
    inks = inks_of(document)
    points = [row for row in document["tables"]["operating_points"] if row["held"]]
    steps = [
        {
            **row,
            "rise_percent": None if row["rise_ms"] is None else 100.0 * row["rise_ms"] / row["allowed_ms"],
        }
        for row in document["tables"]["steps"]
    ]
    overshoot = document["drive"]["overshoot_limit_percent"]
    step_panels = (
        Panel("rise time (%\nof allowed)", "rise_percent", 100.0),
        Panel("overshoot (%)", "overshoot_percent", overshoot),
    )
    found = []
    with house_style():
        if points:
            places = _places(document["tables"]["operating_points"], "reference_nm")
            drawn = draw(
                points,
                places,
                "reference_nm",
                POINT_PANELS,
                inks,
                "torque asked for, or of the load (N·m), by speed",
            )
            caption = (
                "Each column is an operating point, from the least speed to the highest and from light to heavy load; "
                "points that a candidate does not hold are left out. Ripple: greatest less least torque at any instant."
            )
            words = _words(points, POINT_PANELS, inks)
            found.append(_placed("points", "Steady states over the best possible", drawn, words, caption))
        if steps:
            places = _places(steps, "after_nm")
            drawn = draw(
                steps, places, "after_nm", step_panels, inks, "torque after the step (N·m), by speed"
            )
            caption = (
                "Steps of the torque reference for which the voltage leaves room. Dashed: what STP-1 allows."
            )
            words = _words(steps, step_panels, inks)
            found.append(_placed("steps-drawn", "Steps of the torque reference", drawn, words, caption))
    return tuple(found)


def _placed(name: str, title: str, drawn: Figure, alternative: str, caption: str) -> PageFigure:
    return PageFigure(name, title, inline_svg(drawn, name), alternative, caption)


def _places(rows: Sequence[Row], key: str) -> list[tuple[float, float]]:
    return sorted({(row["speed_rpm"], row[key]) for row in rows})


def draw(
    rows: Sequence[Row],
    places: Sequence[tuple[float, float]],
    key: str,
    panels: Sequence[Panel],
    inks: Mapping[str, Ink],
    label: str,
) -> Figure:
    """Draw a mark for each candidate at each place, in a panel for each quantity."""
    figure, axes = new_figure(1.1 + 1.25 * len(panels), len(panels))
    known = {(row["candidate"], row["speed_rpm"], row[key]): row for row in rows}
    shifts = np.linspace(-0.5, 0.5, len(inks) + 2)[1:-1] * _APART
    for axis, panel in zip(axes, panels, strict=True):
        for (candidate, ink), shift in zip(inks.items(), shifts, strict=True):
            marks = [
                (x + shift, row[panel.key])
                for x, place in enumerate(places)
                if (row := known.get((candidate, *place))) is not None and row[panel.key] is not None
            ]
            if marks:
                axis.plot(
                    *zip(*marks, strict=True), ink.marker, color=ink.colour, markersize=4.5, label=ink.label
                )
        if panel.limit is not None:
            axis.axhline(panel.limit, color=VERMILION, linewidth=1.1, linestyle=_DASHED)
        axis.set_ylabel(panel.label)
        axis.set_ylim(bottom=min(0.0, axis.get_ylim()[0]))
        _mark_speeds(axis, places)
    _name_speeds(axes[0], places)
    for axis in axes[:-1]:
        axis.tick_params(labelbottom=False)
    turned = 90 if len(places) > 16 else 0
    axes[-1].set_xticks(range(len(places)), [f"{value:.3g}" for _, value in places], rotation=turned)
    axes[-1].set_xlabel(label)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=9.0)
    return figure


def _groups(places: Sequence[tuple[float, float]]) -> list[tuple[float, int, int]]:
    """Give each speed with its first and its last place."""
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
    for speed, begin, end in _groups(places):
        axis.annotate(
            f"{speed:g} rpm",
            (0.5 * (begin + end), 1.03),
            xycoords=("data", "axes fraction"),
            ha="center",
            fontsize=9.0,
        )


def _words(rows: Sequence[Row], panels: Sequence[Panel], inks: Mapping[str, Ink]) -> str:
    """Describe a figure in words, for who cannot see it."""
    told = []
    for candidate, ink in inks.items():
        ranges = []
        for panel in panels:
            values = [
                row[panel.key] for row in rows if row["candidate"] == candidate and row[panel.key] is not None
            ]
            if values:
                name = panel.label.replace("\n", " ")
                ranges.append(f"{name} from {written(min(values), 2)} to {written(max(values), 2)}")
        told.append(f"{ink.label}: {'; '.join(ranges) or 'nothing'}.")
    return " ".join(told)
