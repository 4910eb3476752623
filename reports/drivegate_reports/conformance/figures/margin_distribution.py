"""How far all runs were from the limit of each check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_reports.page.page import plain_number
from drivegate_reports.page.style import BLUE, GREY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN: Final = 1.0
"""Greatest magnitude of a margin in the figure; what lies beyond is drawn at its border."""
_ROW_INCH: Final = 0.24


@dataclass(frozen=True)
class CheckMargins:
    """The margins of one check over all runs that decide."""

    check: str
    margins: NDArray[np.float64]
    """From the least to the greatest (1), shape (n,)."""


TITLE = "Margins of all runs"


def alternative(rows: Sequence[CheckMargins]) -> str:
    margins = "; ".join(
        f"{row.check} least {plain_number(row.margins[0])}, median {plain_number(float(np.median(row.margins)))}"
        for row in rows
    )
    return f"A row of marks for each check, one for each run, left of zero where it is not met. {margins}."


def caption(rows: Sequence[CheckMargins]) -> str:
    beyond = sum(int(np.count_nonzero(np.abs(row.margins) > SHOWN)) for row in rows)
    hidden = f" {beyond} marks lie beyond the axis and are drawn at its border." if beyond else ""
    return (
        "One mark for each run that decides on the check: the distance from the limit over the limit. Right of zero "
        f"the requirement is met; the thick mark is the median.{hidden}"
    )


def draw(rows: Sequence[CheckMargins]) -> Figure:
    figure, (panel,) = new_figure(0.9 + _ROW_INCH * len(rows), 1)
    for place, row in enumerate(rows):
        shown = np.clip(row.margins, -SHOWN, SHOWN)
        for part, colour in ((shown[row.margins < 0.0], VERMILION), (shown[row.margins >= 0.0], BLUE)):
            panel.vlines(
                np.unique(part.round(3)), place - 0.32, place + 0.32, color=colour, linewidth=1.1, alpha=0.6
            )
        panel.vlines([float(np.median(shown))], place - 0.42, place + 0.42, color="black", linewidth=2.2)
        missed = int(np.count_nonzero(row.margins < 0.0))
        text = f"least {plain_number(row.margins[0])}; {missed} of {row.margins.size} not met"
        colour = VERMILION if missed else GREY
        label(panel, 1.06 * SHOWN, place, text, colour, va="center", fontsize=8.5)
    panel.axvline(0.0, color="black", linewidth=0.9)
    panel.set_yticks(range(len(rows)), [row.check for row in rows])
    panel.set_ylim(len(rows) - 0.4, -0.6)
    panel.set_xlim(-1.05 * SHOWN, 2.0 * SHOWN)
    panel.set_xticks([-1.0, -0.5, 0.0, 0.5, 1.0])
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("margin: distance from the limit over the limit (1)")
    panel.set_ylabel("check (identifier)")
    return figure
