"""The figures of the comparison page, as its contract declares them, drawn from the document alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from drivegate.contracts.drawings import (
    CycleCurves,
    DifferenceBars,
    Drawing,
    RowMarks,
    RunCurves,
    SpeedCurves,
    SpeedLoadMap,
)
from drivegate_reports.comparison.cells import name, written
from drivegate_reports.comparison.curves import (
    change_s,
    draw_cycle,
    draw_differences,
    draw_over_speed,
    draw_run,
    held_rpm,
    loads_shown,
    measured_differences,
)
from drivegate_reports.comparison.inks import Ink
from drivegate_reports.comparison.maps import draw_map, map_words
from drivegate_reports.comparison.marks import draw_marks, marked_rows, marks_in_words
from drivegate_reports.page.page import clean
from drivegate_reports.page.style import PageFigure, page_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Document: TypeAlias = Mapping[str, Any]
Inks: TypeAlias = Mapping[str, Ink]

_PLACES: Final = 4


def placed_figure(
    identifier: str, title: str, draw: Callable[[], Figure], alternative: str, caption: str
) -> PageFigure:
    """Draw a figure and return it with its words, as a page places it."""
    words = clean(alternative), clean(caption)
    return page_figure(f"figure-{identifier}", title, lambda: _settled(draw()), *words)


def _settled(figure: Figure) -> Figure:
    """Lay a figure out once and round that: the layout's solver differs in the last digits from time to time."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    figure.set_layout_engine("none")
    for axis in figure.axes:
        left, bottom, width, height = (round(value, _PLACES) for value in axis.get_position().bounds)
        axis.set_position((left, bottom, width, height))
    return figure


def drawn(document: Document, drawing: Drawing, inks: Inks) -> Iterator[PageFigure]:
    """Draw what a contract declares; nothing where there is nothing to draw."""
    if inks:
        yield from _DRAW[type(drawing)](document, drawing, inks)


def _differences(document: Document, drawing: DifferenceBars, inks: Inks) -> Iterator[PageFigure]:
    panels, first = measured_differences(document, drawing.panels), name(next(iter(inks)))
    if not panels:
        return
    differences = [
        f"{panel.label}: "
        + ", ".join(
            f"{name(row['second'])} {written(-row['mean_difference'], 2, signed=True)} "
            f"({written(-row['high'], 2, signed=True)} to {written(-row['low'], 2, signed=True)})"
            for row in panel.rows
        )
        for panel in panels
    ]
    yield placed_figure(
        "differences",
        f"How much more than {first}, and how sure that is",
        lambda: draw_differences(panels, inks),
        f"Mean paired differences from {first} with their intervals. " + "; ".join(differences) + ".",
        drawing.caption.replace("{first}", first),
    )


def _over_speed(document: Document, drawing: SpeedCurves, inks: Inks) -> Iterator[PageFigure]:
    loads = loads_shown(document)
    words, shown = (
        ", ".join(label for _, label, _ in drawing.panels),
        " and ".join(f"{load:g} %" for load in loads),
    )
    yield placed_figure(
        "over-speed",
        drawing.title,
        lambda: draw_over_speed(document, inks, loads, drawing.panels),
        f"Over speed at {shown} of rated power, for each candidate: {words}. The numbers are in the table of every "
        "operating point.",
        drawing.caption.format(light=f"{loads[0]:g}", heavy=f"{loads[-1]:g}"),
    )


def _map(document: Document, drawing: SpeedLoadMap, inks: Inks) -> Iterator[PageFigure]:
    yield placed_figure(
        f"map-{drawing.key.replace('_', '-')}",
        drawing.title,
        lambda: draw_map(document, inks, drawing),
        map_words(document, inks, drawing),
        f"{drawing.caption} All candidates share the scale, whose ends include everything beyond. A cross is a point "
        "that is not held; the line is the greatest torque of any angle within the current limit.",
    )


def _runs(document: Document, drawing: RunCurves, inks: Inks) -> Iterator[PageFigure]:
    runs = list(dict.fromkeys(entry["run"] for entry in document["trajectories"]))
    words = ", ".join(label for _, label in drawing.panels)
    for number, run in enumerate(runs[: drawing.most], start=1):
        yield placed_figure(
            f"disturbance-{number}",
            clean(run[:1].upper() + run[1:]),
            lambda run=run: draw_run(document, inks, run, drawing.panels),  # type: ignore[misc]
            f"Over time, of each candidate in the run '{run}': {words}.",
            drawing.caption.format(change_s=f"{change_s(document):g}", held_rpm=f"{held_rpm(document):g}"),
        )


def _cycle(document: Document, drawing: CycleCurves, inks: Inks) -> Iterator[PageFigure]:
    if not document["cycle_samples"]:
        return
    first = name(next(iter(inks)))
    rows = [row for row in document["tables"]["drive_cycle"] if row["seed"] is None]
    energies = ", ".join(
        f"{name(row['candidate'])} {written(row['energy_wh_per_km'], 2)} Wh/km" for row in rows
    )
    yield placed_figure(
        "cycle",
        drawing.title,
        lambda: draw_cycle(document, inks),
        f"Speed over time of each candidate and of the cycle, and energy taken so far above that of {first}. "
        f"{energies}.",
        drawing.caption.replace("{first}", first),
    )


def _marks(document: Document, drawing: RowMarks, inks: Inks) -> Iterator[PageFigure]:
    if len(marked_rows(document, drawing)):
        yield placed_figure(
            drawing.name,
            drawing.title,
            lambda: draw_marks(document, drawing, inks),
            marks_in_words(document, drawing, inks),
            drawing.caption,
        )


_DRAW: Final[Mapping[type, Callable[..., Iterator[PageFigure]]]] = {
    DifferenceBars: _differences,
    SpeedCurves: _over_speed,
    SpeedLoadMap: _map,
    RunCurves: _runs,
    CycleCurves: _cycle,
    RowMarks: _marks,
}
