"""The initial angle over speed, with the edge of what is feasible and the best angles (paper, Fig. 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.operating_point import load_operating_point
from drivegate_lab.paper.drives import ideal_drive, reference_drive
from drivegate_lab.paper.figures.input_current import (
    INITIAL_LINE,
    PUBLISHED_LINE,
    input_current_sweep,
    line_angle,
)
from drivegate_models.steady.oracle import least_input_power
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREEN, GREY, SKY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PUBLISHED_POINTS: Final = ("fig9-currents-1200", "fig6-torque-1500", "fig10-currents-1500")
_FIGURE_NAMES: Final = {
    "fig9-currents-1200": "Fig. 9",
    "fig6-torque-1500": "Fig. 6",
    "fig10-currents-1500": "Fig. 10",
}


@dataclass(frozen=True)
class PublishedAngle:
    """A published angle."""

    figure: str
    """Where it is published."""
    speed_rpm: float
    advance_deg: float
    """The point."""


@dataclass(frozen=True)
class InitialAngles:
    """Angles over speed at constant power, in the steady state with ideal current regulators."""

    base_speed_rpm: float
    power_w: float
    """Base speed, and the power at the shaft (W)."""
    speed_rpm: NDArray[np.float64]
    """Speeds above base speed (rpm), shape (n,)."""
    published_deg: NDArray[np.float64]
    initial_deg: NDArray[np.float64]
    """The published line, and the one that `reference` starts from (electrical deg), shape (n,)."""
    edge_deg: NDArray[np.float64]
    """Smallest angle that gives the power (electrical deg), shape (n,)."""
    least_current_deg: NDArray[np.float64]
    least_power_deg: NDArray[np.float64]
    """Angles of least Σ|i| and of least net input power (electrical deg), shape (n,)."""
    points: tuple[PublishedAngle, ...]
    """Published single angles."""


@cache
def initial_angles() -> InitialAngles:
    """Compute the angles over the speeds of the sweep of Fig. 7."""
    sweep = input_current_sweep()
    speeds = sweep.speed_rpm * RADIANS_PER_RPM
    least_power = [least_input_power(ideal_drive(), speed, sweep.power_w / speed).advance for speed in speeds]
    points = [(name, load_operating_point(name)) for name in PUBLISHED_POINTS]
    return InitialAngles(
        base_speed_rpm=reference_drive().rating.base_speed_rpm,
        power_w=sweep.power_w,
        speed_rpm=sweep.speed_rpm,
        published_deg=sweep.published_deg,
        initial_deg=sweep.initial_deg,
        edge_deg=sweep.edge_deg,
        least_current_deg=sweep.optimal_deg,
        least_power_deg=np.degrees(least_power),
        points=tuple(
            PublishedAngle(_FIGURE_NAMES[name], point.speed_rpm, point.advance_deg) for name, point in points
        ),
    )


TITLE = "Initial advance angle over speed (Fig. 3)"


def alternative(data: InitialAngles) -> str:
    """Describe the figure in words, for who cannot see it."""
    inside = data.speed_rpm[data.published_deg < data.edge_deg]
    reached = f"below it up to {inside[-1]:.0f} rpm" if inside.size else "never below it"
    return (
        f"All angles are 0° up to {data.base_speed_rpm:.0f} rpm. Above, the feasible edge rises from "
        f"{data.edge_deg[0]:.0f}° to {data.edge_deg[-1]:.0f}° at {data.speed_rpm[-1]:.0f} rpm. The published line, "
        f"from 0° at base speed, is {reached}; the line of `reference` is above it throughout. The angle "
        "of least current "
        f"lies on or just above the edge, that of least power between {data.least_power_deg.min():.0f}° and "
        f"{data.least_power_deg.max():.0f}°."
    )


def caption(data: InitialAngles) -> str:
    """State what the figure shows."""
    return (
        f"Constant power of {data.power_w / 1000.0:g} kW with ideal regulators. In the grey region no current up to "
        f"the limit gives the power. `published` starts from 0° + {PUBLISHED_LINE[1]:g}°/rpm above base "
        "speed, the line "
        f"through the points of Figs. 9 and 10; `reference` from {INITIAL_LINE[0]:g}° + {INITIAL_LINE[1]:g}°/rpm, "
        "which clears the region. Both are 0° below base speed. Fig. 3 gives no numbers for its line."
    )


def draw(data: InitialAngles) -> Figure:
    """Draw the angles over speed."""
    figure, (panel,) = new_figure(4.6, 1)
    speeds = data.speed_rpm
    panel.fill_between(speeds, 0.0, data.edge_deg, color=GREY, alpha=0.18, linewidth=0)
    _draw_line(panel, data, PUBLISHED_LINE, GREEN)
    _draw_line(panel, data, INITIAL_LINE, VERMILION)
    panel.plot(speeds, data.edge_deg, color=GREY, linewidth=1.2)
    panel.plot(speeds, data.least_current_deg, color=BLUE)
    panel.plot(speeds, data.least_power_deg, color=SKY, linewidth=1.3)
    end = float(speeds[-1]) + 20.0
    label(
        panel, end, data.initial_deg[-1], "`reference`\nstarts here".replace("`", ""), VERMILION, va="center"
    )
    label(panel, end, data.published_deg[-1], "published line", GREEN, va="center")
    label(panel, end, data.least_current_deg[-1] - 1.0, "least Σ|i|", BLUE, va="top", weight="bold")
    label(panel, end, data.least_power_deg[-1], "least watts", SKY, va="bottom")
    text = f"{data.power_w / 1000.0:g} kW out of reach"
    label(panel, 1450.0, 16.0, text, GREY, ha="center")
    for point in data.points:
        panel.plot([point.speed_rpm], [point.advance_deg], color="black", marker="o", markersize=5)
        # Below the curves, or above them: two of the points lie on one.
        right, up, side = (22.0, -4.5, "left") if point.figure == "Fig. 6" else (-22.0, 4.4, "right")
        panel.text(
            point.speed_rpm + right,
            point.advance_deg + up,
            point.figure,
            fontsize=9.0,
            ha=side,
            va="center",
        )
    panel.set_xlim(0.0, 2440.0)
    panel.set_ylim(-2.0, 94.0)
    panel.set_xticks(np.arange(0.0, 2001.0, 250.0))
    panel.set_xlabel("speed (rpm)")
    panel.set_ylabel("advance angle (el. deg)")
    return figure


def _draw_line(panel: Axes, data: InitialAngles, line: tuple[float, float], colour: str) -> None:
    base = math.floor(data.base_speed_rpm)
    above = np.array([base, *data.speed_rpm])
    panel.plot(above, [line_angle(line, speed) for speed in above], color=colour)
    panel.plot([0.0, base], [0.0, 0.0], color=colour)
