"""The figures of the comparison page, drawn from the comparison document alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from drivegate_reports.comparison.cells import name, written
from drivegate_reports.comparison.curves import (
    change_s,
    draw_cycle,
    draw_differences,
    draw_disturbance,
    draw_over_speed,
    held_rpm,
    loads_shown,
    measured_differences,
)
from drivegate_reports.comparison.inks import Ink, inks_of
from drivegate_reports.comparison.maps import MAPS, draw_map, map_words
from drivegate_reports.page.figure import PageFigure
from drivegate_reports.page.printable import clean
from drivegate_reports.page.style import house_style, inline_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PLACES: Final = 4
SHOWN_DISTURBANCES: Final = 2
"""How many disturbances are drawn."""


@dataclass(frozen=True)
class ComparisonFigures:
    """The figures by the section that they stand in."""

    differences: tuple[PageFigure, ...]
    points: tuple[PageFigure, ...]
    disturbances: tuple[PageFigure, ...]
    cycle: tuple[PageFigure, ...]
    """Empty where there is nothing to draw."""


def comparison_figures(document: Mapping[str, Any]) -> ComparisonFigures:
    """Draw everything."""
    inks = inks_of(document)
    with house_style():
        return ComparisonFigures(
            differences=tuple(_differences(document, inks)),
            points=(*_over_speed(document, inks), *_maps(document, inks)),
            disturbances=tuple(_disturbances(document, inks)),
            cycle=tuple(_cycle(document, inks)),
        )


def placed_figure(
    identifier: str, title: str, draw: Callable[[], Figure], alternative: str, caption: str
) -> PageFigure:
    """Draw a figure and give it with its words, as a page places it."""
    svg = inline_svg(_settled(draw()), f"figure-{identifier}")
    return PageFigure(f"figure-{identifier}", title, svg, clean(alternative), clean(caption))


def _settled(figure: Figure) -> Figure:
    """Lay a figure out once and round that: the layout's solver differs in the last digits from time to time."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axis in figure.axes:
        left, bottom, width, height = (round(value, _PLACES) for value in axis.get_position().bounds)
        axis.set_position((left, bottom, width, height))
    return figure


def _differences(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Sequence[PageFigure]:
    panels = measured_differences(document)
    if not panels:
        return []
    first = name(next(iter(inks)))
    differences = [
        f"{panel.title}: "
        + ", ".join(
            f"{name(row.candidate)} {written(row.mean, 2, signed=True)} {panel.unit} "
            f"({written(row.low, 2, signed=True)} to {written(row.high, 2, signed=True)})"
            for row in panel.rows
        )
        for panel in panels
    ]
    return [
        placed_figure(
            "differences",
            f"How much more than {first}, and how sure that is",
            lambda: draw_differences(panels, inks),
            f"Mean paired differences from {first} with their intervals. " + "; ".join(differences) + ".",
            f"Mean paired difference from {first} and its interval; to the right of zero is more. Open markers: "
            "no real difference. Only runs that both hold are paired.",
        )
    ]


def _over_speed(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Sequence[PageFigure]:
    if not inks:
        return []
    loads = loads_shown(document)
    shown = " and ".join(f"{load:g} %" for load in loads)
    return [
        placed_figure(
            "over-speed",
            "Σ|i| and input power over speed",
            lambda: draw_over_speed(document, inks, loads),
            f"Current sum, and input power above the best possible, over speed at {shown} of rated power, for each "
            "candidate. The numbers are in the table of every operating point.",
            f"Left at {loads[0]:g} %, right at {loads[-1]:g} % of rated power. The grey line is the least Σ|i| that "
            "any angle gives; input power is shown above the least that any angle gives. A point that is not held is "
            "left out.",
        )
    ]


def _maps(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Sequence[PageFigure]:
    if not inks:
        return []
    return [
        placed_figure(
            f"map-{quantity.key.replace('_', '-')}",
            quantity.title,
            lambda quantity=quantity: draw_map(document, inks, quantity),  # type: ignore[misc]
            map_words(document, inks, quantity),
            f"{quantity.caption} All candidates share the scale, whose ends hold everything beyond. A cross is a "
            "point that is not held; the line is the greatest torque that any angle gives within the current limit.",
        )
        for quantity in MAPS
    ]


def _disturbances(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Sequence[PageFigure]:
    runs = list(dict.fromkeys(entry["run"] for entry in document["trajectories"]))
    return [
        placed_figure(
            f"disturbance-{number}",
            clean(run[:1].upper() + run[1:]),
            lambda run=run: draw_disturbance(document, inks, run),  # type: ignore[misc]
            f"Speed error, advance angle and current sum of each candidate over time in the run '{run}'.",
            "Largest speed error of each 50 ms, advance angle, and mean Σ|i| of each 50 ms, all candidates overlaid; "
            f"the disturbance comes at {change_s(document):g} s. The dotted lines are the "
            f"{held_rpm(document):g} rpm within which a speed counts as held.",
        )
        for number, run in enumerate(runs[:SHOWN_DISTURBANCES], start=1)
    ]


def _cycle(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Sequence[PageFigure]:
    entries = document["cycle_samples"]
    if not entries:
        return []
    first = name(next(iter(inks)))
    rows = [row for row in document["tables"]["drive_cycle"] if row["seed"] is None]
    energies = ", ".join(
        f"{name(row['candidate'])} {written(row['energy_wh_per_km'], 2)} Wh/km" for row in rows
    )
    return [
        placed_figure(
            "cycle",
            "The drive cycle, with ideal sensors",
            lambda: draw_cycle(document, inks),
            f"Speed over time of each candidate beside the cycle, and energy taken so far above that of {first}. "
            f"{energies}.",
            f"Top: the cycle in grey and every candidate's speed. Bottom: energy taken so far, less that of {first}. "
            "Who leaves the cycle saves energy that way; the table says who follows.",
        )
    ]
