"""Torque over one electrical cycle at three times base speed (paper, Fig. 6)."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from drivegate_cases.scenario.operating_point import load_operating_point
from drivegate_lab.paper.drives import ideal_drive
from drivegate_reports.conformance.figures.torque_ripple import TorqueCycle, cycle_at
from drivegate_reports.page.style import BLUE, GREY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINT = "fig6-torque-1500"
ADVANCE_DEG = 52.5
"""Angle of the figure: a little above the smallest one at which the torque can be produced."""
LIMIT_PERCENT = 13.0
"""The published limit of the ripple."""


@cache
def torque_cycle(advance_deg: float = ADVANCE_DEG) -> TorqueCycle:
    """Compute the torque at the speed and mean torque of Fig. 6."""
    point = load_operating_point(POINT)
    return cycle_at(ideal_drive(), point.speed_rpm, advance_deg, point.torque_nm)


TITLE = "Torque at three times base speed (Fig. 6)"


def alternative(data: TorqueCycle) -> str:
    """Describe the figure in words, for who cannot see it."""
    return (
        f"Torque over one electrical cycle repeats ten times between {data.lowest_nm:.2f} and "
        f"{data.highest_nm:.2f} N·m around its mean of {data.mean_nm:.2f} N·m: a ripple of "
        f"{data.ripple_percent:.1f} % peak to peak."
    )


def caption(data: TorqueCycle) -> str:
    """State what the figure shows."""
    state = "certified periodic" if data.certified else "not exactly periodic"
    return (
        f"Steady state at {data.speed_rpm:.0f} rpm, {data.advance_deg:g}° and {data.current_reference_a:.2f} A with "
        f"ideal current regulators, {state}. Extremes are exact, not taken from a grid. Ripple is "
        f"{data.ripple_percent:.1f} % peak to peak over the mean, {data.one_sided_ripple_percent:.1f} % one-sided; "
        f"the published limit is {LIMIT_PERCENT:.0f} %."
    )


def draw(data: TorqueCycle) -> Figure:
    """Draw the torque with its mean and extremes."""
    figure, (panel,) = new_figure(3.3, 1)
    panel.fill_between([0.0, 360.0], data.lowest_nm, data.highest_nm, color=BLUE, alpha=0.10, linewidth=0)
    panel.plot(data.angle_deg, data.torque_nm, color=BLUE, linewidth=1.5)
    panel.plot([0.0, 360.0], [data.mean_nm] * 2, color=VERMILION, linewidth=1.2, linestyle=(0, (5, 3)))
    right = 364.0
    label(panel, right, data.highest_nm, f"max {data.highest_nm:.2f}", BLUE, va="bottom")
    label(panel, right, data.mean_nm, f"mean {data.mean_nm:.2f}", VERMILION, va="center", weight="bold")
    label(panel, right, data.lowest_nm, f"min {data.lowest_nm:.2f}", BLUE, va="top")
    text = f"peak to peak over mean: {data.ripple_percent:.1f} %  (published: below {LIMIT_PERCENT:.0f} %)"
    label(panel, 180.0, 0.5 * data.mean_nm, text, GREY, ha="center", va="center", fontsize=10.0)
    panel.set_xlim(0.0, 420.0)
    panel.set_ylim(0.0, 1.15 * data.highest_nm)
    panel.set_xticks(np.arange(0.0, 361.0, 72.0))
    panel.set_xlabel("electrical angle since the first phase's window opened (el. deg)")
    panel.set_ylabel("torque (N·m)")
    return figure
