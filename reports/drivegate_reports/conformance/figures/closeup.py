"""The moment of a run that decides a check, at full resolution, with the limit and what was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivegate.checks.margin import Moment
from drivegate.contracts.contract import Columns
from drivegate.contracts.drawings import TIME, Panel, panels_for
from drivegate.output.panels import MomentTime, draw_moment, quantity_of
from drivegate_reports.page.style import (
    BLUE,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    VERMILION,
    label_ends,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INKS = (VERMILION, BLUE, GREEN, ORANGE, SKY)


def title(moment: Moment) -> str:
    return f"What decides: {moment.start_s:.6g} s to {moment.end_s:.6g} s"


def alternative(moment: Moment, panels: tuple[Panel, ...]) -> str:
    axis = MomentTime(moment)
    words = [f"{axis.of(moment.end_s) - axis.of(moment.start_s):.3g} {axis.unit} of the run."]
    if moment.is_marked:
        words.append(f"Shown is {moment.quantity or quantity_of(moment.column, panels)}.")
    words += [
        f"{course.words}: {min(course.values):.4g} to {max(course.values):.4g}." for course in moment.courses
    ]
    words += [f"Line at {level.value:.4g}: {level.words}." for level in moment.levels]
    words += [f"At {axis.of(mark.value):.3g} {axis.unit}: {mark.words}." for mark in moment.instants]
    if moment.point is not None:
        words.append(f"Measured {moment.point.words}, at {axis.of(moment.point.time_s):.3g} {axis.unit}.")
    return " ".join(words)


def caption(moment: Moment) -> str:
    marked = " Dashed red: references and limits; the ring is what was measured." if moment.is_marked else ""
    return (
        f"The moment of the run that decides, with its signals control period by control period.{marked} Dotted: what "
        "the controller sensed."
    )


def draw(moment: Moment, columns: Columns, panels: tuple[Panel, ...]) -> Figure:
    """Draw the column that decides above the other signals of the same moment."""
    others = [
        panel
        for panel in panels_for(panels, columns)
        if [line.column for line in panel.lines if not line.is_reference] != [moment.column]
    ]
    ratios = ((2.4,) if moment.is_marked else ()) + (1.0,) * len(others)
    figure, axes = new_figure(0.9 + 0.9 * sum(ratios), len(ratios), ratios, fitted=False, apart=0.3)
    if moment.is_marked:
        draw_moment(axes[0], moment, columns, panels)
        axes[0].set_xlabel("")
    axis = MomentTime(moment)
    for panel, shown in zip(axes[-len(others) :], others, strict=True):
        _draw_panel(panel, axis, columns, shown)
    for panel in axes[:-1]:
        panel.tick_params(labelbottom=False)
    axes[-1].set_xlabel(axis.label)
    figure.align_ylabels(axes)
    return figure


def _draw_panel(axes: Axes, axis: MomentTime, columns: Columns, panel: Panel) -> None:
    time = axis.factor * (columns[TIME] - axis.origin)
    is_alone = sum(not (line.is_reference or line.is_sensed) for line in panel.lines) == 1
    inks = iter((BLUE, VERMILION) if is_alone else _INKS)
    ends = []
    for line in panel.lines:
        colour = GREY if line.is_reference else next(inks, BLUE)
        style = DASHED if line.is_reference else DOTTED if line.is_sensed else "-"
        axes.plot(time, columns[line.column], color=colour, linewidth=1.2, linestyle=style)
        ends.append((line.name, float(columns[line.column][-1]), colour))
    axes.set_ylabel(panel.label)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.margins(y=0.15)
    axis.apply(axes)
    label_ends(axes, axis.labels_at, *ends)
