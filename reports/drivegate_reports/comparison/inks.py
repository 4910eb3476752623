"""How the candidates of a comparison are distinguished in every figure: by colour, dash and a label beside the line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate_reports.comparison.cells import name
from drivegate_reports.page.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION

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
