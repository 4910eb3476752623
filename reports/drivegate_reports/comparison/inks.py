"""How the candidates of a comparison are distinguished in every figure: by colour, dash and a label beside the line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate_reports.comparison.cells import name
from drivegate_reports.page.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION

_COLOURS: Final = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, GREY)
_DASHES: Final = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)))
_MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
_LONGEST_LABEL: Final = 24


@dataclass(frozen=True)
class Ink:
    """How a candidate is drawn.

    Attributes
    ----------
    label : str
        Its name, short enough for a figure.
    colour : str
        One of the house's colours.
    dash : object
        A line style of matplotlib.
    marker : str
        A marker of matplotlib.
    """

    label: str
    colour: str
    dash: Any
    marker: str


def inks_of(document: Mapping[str, Any]) -> dict[str, Ink]:
    """Give every candidate that ran its own look."""
    order = [entry["label"] for entry in document["candidates"]]
    inks = {}
    for row in document["tables"]["ranking"]:
        if row["status"] == "refused":
            continue
        place = order.index(row["candidate"])
        inks[row["candidate"]] = Ink(
            _short(row["candidate"]),
            _COLOURS[place % len(_COLOURS)],
            _DASHES[(place // len(_COLOURS)) % len(_DASHES)]
            if place >= len(_COLOURS)
            else _DASHES[place % 4],
            _MARKERS[place % len(_MARKERS)],
        )
    return inks


def _short(label: str) -> str:
    # A dollar sign would begin a formula.
    text = name(label).replace("$", r"\$").replace("\n", " ")
    return text if len(text) <= _LONGEST_LABEL else text[: _LONGEST_LABEL - 1] + "…"
