"""The figures of the page that compares drives: over per-unit speed at full load, drives by colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate_reports.comparison.cells import name, written
from drivegate_reports.comparison.figures import placed_figure
from drivegate_reports.comparison.inks import COLOURS, DASHES, MARKERS, legend_below, line_style, short_label
from drivegate_reports.page.style import GREY, WIDTH_INCH, PageFigure, house_style, ink

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OVER_SPEED: Final = (
    ("ripple_percent", "torque ripple (%)"),
    ("current_sum_pu", "Σ|i| (pu)"),
    ("input_power_pu", "input power (pu)"),
    ("efficiency_percent", "efficiency (%)"),
)
_LOSSES: Final = (
    ("electrical_losses_pu", "electrical losses (pu)"),
    ("mechanical_losses_pu", "mechanical losses (pu)"),
)
_FROM_ZERO: Final = ("ripple_percent", "current_sum_pu", "electrical_losses_pu")
_SPEED: Final = "speed (pu of base speed)"


def drive_figures(document: Mapping[str, Any]) -> tuple[PageFigure, ...]:
    """Draw everything."""
    with house_style():
        return (
            _full_load(
                document,
                "full-load",
                "At full load over speed",
                _OVER_SPEED,
                "Each drive at rated power, over speed per unit of its own base speed. A point that is not held is "
                "left out.",
            ),
            _full_load(
                document,
                "losses",
                "Losses at full load over speed",
                _LOSSES,
                "Left between the supply and the torque, right between the torque and the load, over rated power.",
            ),
            placed_figure(
                "greatest-power",
                "Greatest shaft power at the current limit",
                lambda: draw_greatest_power(document),
                "Greatest shaft power of each drive over speed, per unit of rated power, up to overspeed. "
                + " ".join(
                    f"{name(row['drive'])}: rated power up to {written(row['constant_power_up_to_pu'], 2)} pu."
                    for row in document["tables"]["drives"]
                ),
                "What the drive gives at the current limit, whatever the controller, up to overspeed; 1 is rated "
                "power. A marker below it is a speed at which a candidate held rated power.",
            ),
        )


def _full_load(
    document: Mapping[str, Any], identifier: str, title: str, panels: Sequence[tuple[str, str]], caption: str
) -> PageFigure:
    words = ", ".join(label for _, label in panels)
    described = "; ".join(
        f"{name(row['candidate'])} on {name(row['drive'])}" for row in document["tables"]["summary"]
    )
    return placed_figure(
        identifier,
        title,
        lambda: draw_full_load(document, panels),
        f"Over per-unit speed at full load: {words}. {described}. The numbers are in the table of "
        "every operating point.",
        caption,
    )


def _style(colour: str, number: int) -> dict[str, Any]:
    return line_style(colour, DASHES[number % len(DASHES)], MARKERS[number % len(MARKERS)])


def _lines(document: Mapping[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    """List candidate, drive and look of each line: the drive by its colour, the candidate by dash and marker."""
    return [
        (candidate["label"], drive["label"], _style(COLOURS[place % len(COLOURS)], number))
        for number, candidate in enumerate(document["candidates"])
        for place, drive in enumerate(document["drives"])
    ]


def _full_load_rows(document: Mapping[str, Any], candidate: str, drive: str) -> list[Mapping[str, Any]]:
    points = document["tables"]["operating_points"]
    heaviest = max((row["load_percent"] for row in points), default=None)
    rows = [
        row
        for row in points
        if row["candidate"] == candidate and row["drive"] == drive and row["load_percent"] == heaviest
    ]
    return sorted(rows, key=lambda row: float(row["speed_pu"]))


def draw_full_load(document: Mapping[str, Any], panels: Sequence[tuple[str, str]]) -> Figure:
    """Draw quantities at full load over per-unit speed."""
    from matplotlib.figure import Figure as NewFigure

    rows = -(-len(panels) // 2)
    figure = NewFigure(figsize=(WIDTH_INCH, 0.7 + 2.3 * rows), layout="constrained")
    axes: list[Axes] = list(figure.subplots(rows, 2, squeeze=False, sharex=True).flat)
    for candidate, drive, style in _lines(document):
        found = _full_load_rows(document, candidate, drive)
        speeds = [row["speed_pu"] for row in found]
        for axis, (key, _) in zip(axes, panels, strict=False):
            values = [row[key] if row["held"] and row[key] is not None else np.nan for row in found]
            axis.plot(speeds, values, **style)
    for axis, (key, label) in zip(axes, panels, strict=False):
        axis.set_ylabel(label)
        axis.margins(x=0.05)
        if key in _FROM_ZERO:
            axis.set_ylim(bottom=0.0)
    for axis in axes[-2:]:
        axis.set_xlabel(_SPEED)
    _legend(figure, document)
    return figure


def draw_greatest_power(document: Mapping[str, Any]) -> Figure:
    """Draw the greatest power of each drive over speed, and where candidates held rated power."""
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(WIDTH_INCH, 3.2), layout="constrained")
    axis = figure.subplots()
    axis.axhline(1.0, color=ink(GREY), linewidth=1.0, linestyle=":")
    for place, entry in enumerate(document["drives"]):
        rows = [row for row in document["tables"]["greatest_power"] if row["drive"] == entry["label"]]
        axis.plot(
            [row["speed_pu"] for row in rows],
            [row["greatest_power_pu"] for row in rows],
            color=COLOURS[place % len(COLOURS)],
        )
    lines = _lines(document)
    for place, (candidate, drive, style) in enumerate(lines):
        held = [row["speed_pu"] for row in _full_load_rows(document, candidate, drive) if row["held"]]
        # Below rated power, each at a height of its own, so that none covers another.
        height = 0.9 * (1.0 - (place + 0.5) / len(lines))
        axis.plot(held, [height] * len(held), **{**style, "linestyle": "none"}, zorder=3)
    axis.set_xlabel(_SPEED)
    axis.set_ylabel("greatest shaft power (pu)")
    axis.set_ylim(bottom=0.0)
    _legend(figure, document)
    return figure


def _legend(figure: Figure, document: Mapping[str, Any]) -> None:
    drives, candidates = (
        [short_label(entry["label"]) for entry in document[key]] for key in ("drives", "candidates")
    )
    colours: list[tuple[str, dict[str, Any]]] = [
        (label, {"color": COLOURS[place % len(COLOURS)], "linewidth": 4.0})
        for place, label in enumerate(drives)
    ]
    dashes = [(label, _style(ink(GREY), number)) for number, label in enumerate(candidates)]
    legend_below(figure, [*colours, *dashes])
