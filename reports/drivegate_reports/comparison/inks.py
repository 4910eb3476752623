"""How the candidates of a comparison are distinguished in every figure: by colour, dash and a label beside the line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from drivegate_reports.comparison.cells import name
from drivegate_reports.page.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS: Final = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, GREY)
"""The house's colours in the order in which lines get them."""
DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)))
"""Line styles in the same order."""
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
"""Markers in the same order."""
_LONGEST_LABEL: Final = 24


@dataclass(frozen=True)
class Ink:
    """How a candidate is drawn."""

    label: str
    """Its name, short enough for a figure."""
    colour: str
    """One of the house's colours."""
    dash: Any
    """A line style of matplotlib."""
    marker: str
    """A marker of matplotlib."""

    @property
    def style(self) -> dict[str, Any]:
        """How matplotlib draws its lines."""
        return line_style(self.colour, self.dash, self.marker)


def line_style(colour: str, dash: Any, marker: str) -> dict[str, Any]:
    """Return how matplotlib draws a line with small markers."""
    return {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4}


def legend_below(figure: Figure, styles: Iterable[tuple[str, Mapping[str, Any]]]) -> None:
    """Explain lines, each by its label and its style, below a figure."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], label=label, **style) for label, style in styles]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(len(handles), 4), frameon=False, fontsize=9.0
    )


def inks_of(document: Mapping[str, Any]) -> dict[str, Ink]:
    """Give every candidate that ran its own look."""
    order = [entry["label"] for entry in document["candidates"]]
    inks = {}
    for row in document["tables"]["ranking"]:
        if row["status"] == "refused":
            continue
        place = order.index(row["candidate"])
        inks[row["candidate"]] = Ink(
            short_label(row["candidate"]),
            COLOURS[place % len(COLOURS)],
            DASHES[(place // len(COLOURS)) % len(DASHES)] if place >= len(COLOURS) else DASHES[place % 4],
            MARKERS[place % len(MARKERS)],
        )
    return inks


def short_label(label: str) -> str:
    """Make a name short enough for a figure."""
    # A dollar sign would begin a formula.
    text = name(label).replace("$", r"\$").replace("\n", " ")
    return text if len(text) <= _LONGEST_LABEL else text[: _LONGEST_LABEL - 1] + "…"
