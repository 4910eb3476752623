"""The loss at eight operating points over the least that any controller could have had there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from drivegate.results.sections import EfficiencyPointSection
from drivegate_cases.documents.wording import figure
from drivegate_reports.page.style import BLUE, DASHED, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLE: Final = "Loss at the eight operating points"


def name_of(point: EfficiencyPointSection) -> str:
    """Name an operating point by its shares of base speed and of rated torque."""
    return f"{100.0 * point.speed_share:.0f} % speed, {100.0 * point.torque_share:.0f} % torque"


def alternative(points: Sequence[EfficiencyPointSection]) -> str:
    stated = [f"{_excess(point)} at {name_of(point)}" for point in points]
    return f"Loss above the least possible: {'; '.join(stated)}."


def caption(limit_percent: float) -> str:
    return (
        "Copper and core loss of the fundamental over the least that gives the same torque within the limits of "
        "current and voltage. The points are derived from those of IEC 61800-9-2: shares of base speed and rated "
        f"torque. Dashed: the advisory limit of {limit_percent:g} %."
    )


def draw(points: Sequence[EfficiencyPointSection], limit_percent: float) -> Figure:
    drawn, (panel,) = new_figure(0.9 + 0.26 * len(points), 1)
    excess = [point.above_least_percent or 0.0 for point in points]
    places = range(len(points))
    colours = [BLUE if value <= limit_percent else VERMILION for value in excess]
    panel.barh(places, excess, height=0.6, color=colours)
    panel.axvline(limit_percent, color=VERMILION, linewidth=1.2, linestyle=DASHED)
    end = 1.2 * max(*excess, limit_percent)
    for place, point, value, colour in zip(places, points, excess, colours, strict=True):
        label(panel, max(value, 0.0) + 0.01 * end, place, _excess(point), colour, va="center", fontsize=8.5)
    panel.set_yticks(list(places), [name_of(point) for point in points])
    panel.invert_yaxis()
    panel.set_xlim(0.0, end)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("loss above the least (%)")
    return drawn


def _excess(point: EfficiencyPointSection) -> str:
    value = point.above_least_percent
    return "not known" if value is None else f"{figure(round(value, 3))} %"
