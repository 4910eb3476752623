"""Which share of all runs has at most which margin, a panel for each check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_reports.page.page import plain_number
from drivegate_reports.page.style import BLUE, VERMILION, WIDTH_INCH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN: Final = 1.0
"""Greatest magnitude of a margin in the figure; what lies beyond is drawn at its border."""
TITLE: Final = "Distribution of margins"
CAPTION: Final = (
    "The share of the runs whose margin is at most so large: the distance from the limit over the limit. Left of zero "
    "the requirement is violated, so the height of the curve there is the share of violations. What lies beyond ±1 is "
    "drawn at the border."
)
_ACROSS: Final = 3
_ROW_INCH: Final = 1.3
_FOOT_INCH: Final = 0.5
_HEAD_INCH: Final = 0.28
_ROOM: Final = 0.05


@dataclass(frozen=True)
class CheckDistribution:
    check: str
    margins: NDArray[np.float64]
    """From the least to the greatest, at equal shares of the runs (1), shape (n,)."""
    violated: str
    """How many runs violate it, in words."""


def alternative(rows: Sequence[CheckDistribution]) -> str:
    worded = "; ".join(
        f"{row.check}: least {plain_number(row.margins[0])}, median {plain_number(_median(row))}, "
        f"greatest {plain_number(row.margins[-1])}, {row.violated} violated"
        for row in rows
    )
    return f"A rising curve for each check, from no run to all of them. {worded}."


def draw(rows: Sequence[CheckDistribution]) -> Figure:
    """Draw the cumulative distribution of each check's margins."""
    from matplotlib.figure import Figure as NewFigure

    down = -(-len(rows) // _ACROSS)
    height = _HEAD_INCH + _FOOT_INCH + _ROW_INCH * down
    figure = NewFigure(figsize=(WIDTH_INCH, height))
    figure.subplots_adjust(
        left=0.08,
        right=0.985,
        top=1.0 - _HEAD_INCH / height,
        bottom=_FOOT_INCH / height,
        hspace=0.5,
        wspace=0.16,
    )
    panels = figure.subplots(down, _ACROSS, squeeze=False).ravel()
    for place, (panel, row) in enumerate(zip(panels, rows, strict=False)):
        _draw(panel, row)
        panel.tick_params(labelleft=place % _ACROSS == 0, labelbottom=place + _ACROSS >= len(rows))
        if place % _ACROSS == 0:
            panel.set_ylabel("share (1)")
        if place + _ACROSS >= len(rows):
            panel.set_xlabel("margin (1)")
    for panel in panels[len(rows) :]:
        panel.remove()
    return figure


def _draw(panel: Axes, row: CheckDistribution) -> None:
    edges = np.clip(row.margins, -SHOWN, SHOWN)
    below = int(np.count_nonzero(row.margins < 0.0))
    shares = np.arange(1, len(edges) + 1) / len(edges)
    panel.axvspan(-SHOWN - _ROOM, 0.0, color=VERMILION, alpha=0.07, linewidth=0)
    panel.axvline(0.0, color="black", linewidth=0.9)
    if below:
        panel.step(
            [edges[0], *edges[:below], 0.0],
            [0.0, *shares[:below], shares[below - 1]],
            where="post",
            color=VERMILION,
        )
    start = shares[below - 1] if below else 0.0
    first = 0.0 if below else -SHOWN - _ROOM
    panel.step(
        [first, *edges[below:], SHOWN + _ROOM], [start, *shares[below:], 1.0], where="post", color=BLUE
    )
    panel.set_xlim(-SHOWN - _ROOM, SHOWN + _ROOM)
    panel.set_ylim(-_ROOM, 1.0 + _ROOM)
    panel.set_xticks([-1.0, 0.0, 1.0], ["−1", "0", "1"])
    panel.set_yticks([0.0, 0.5, 1.0])
    panel.set_title(f"{row.check}: {row.violated} violated", fontsize=9.0)


def _median(row: CheckDistribution) -> float:
    return float(np.quantile(row.margins, 0.5, method="inverted_cdf"))
