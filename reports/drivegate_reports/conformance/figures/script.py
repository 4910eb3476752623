"""What a controller senses in a script, row by row: speed with its reference, and the sum of the phase currents."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from drivegate_cases.scenario.script import Script
from drivegate_reports.page.style import BLUE, DASHED, GREY, label_ends, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTION: Final = (
    "A script has no plant: each row is held for one period of the search, which has to answer the changes "
    "as the flowchart does."
)
_MOST_TICKS: Final = 12


def alternative(script: Script) -> str:
    errors = [row.speed_rpm - row.speed_reference_rpm for row in script.rows]
    sums = [row.current_sum_a for row in script.rows]
    return (
        f"Two panels over {len(script.rows)} rows. The speed lies from {min(errors):+.3g} to {max(errors):+.3g} rpm "
        f"off its reference. Σ|i| goes from {sums[0]:.4g} A to {sums[-1]:.4g} A, at least {min(sums):.4g} A "
        f"and at most {max(sums):.4g} A."
    )


def draw(script: Script) -> Figure:
    figure, (speed, current) = new_figure(3.6, 2, fitted=False)
    count = len(script.rows)
    edges = np.arange(count + 1) + 0.5
    for panel, unit, lines in (
        (speed, "speed (rpm)", (("speed_reference_rpm", "reference", GREY), ("speed_rpm", "speed", BLUE))),
        (current, "current (A)", (("current_sum_a", "Σ|i|", BLUE),)),
    ):
        ends = []
        for key, name, colour in lines:
            values = [getattr(row, key) for row in script.rows]
            style = DASHED if colour == GREY else "-"
            panel.stairs(values, edges, baseline=None, color=colour, linewidth=1.4, linestyle=style)
            ends.append((name, float(values[-1]), colour))
        panel.set_xlim(edges[0], edges[-1] + 0.2 * count)
        panel.set_xticks(np.unique(np.linspace(1, count, min(count, _MOST_TICKS)).round()))
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.margins(y=0.15)
        panel.set_ylabel(unit)
        label_ends(panel, edges[-1] + 0.012 * count, *ends)
    current.set_xlabel("row (periods of the search)")
    return figure
