"""What the optimal angle saves against the initial one, in current and in watts (paper, Fig. 7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.operating_point import load_power_sweep
from drivegate_lab.paper.drives import ideal_drive, reference_drive
from drivegate_models.steady.oracle import feasible_edge, least_current_sum, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREEN, GREY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SWEEP = "fig7-input-current"
INITIAL_LINE = (33.0, 0.025)
"""Initial angle of `reference` and `initial`: at base speed (deg), and slope (deg/rpm)."""
PUBLISHED_LINE = (0.0, 0.058)
"""The line through (500 rpm, 0°) and (1500 rpm, 58°), as `published` has it."""


@dataclass(frozen=True)
class InputCurrentSweep:
    """Constant power over speed at two angles, in the steady state with ideal current regulators."""

    power_w: float
    """Power at the shaft (W)."""
    speed_rpm: NDArray[np.float64]
    """Shaft speed (rpm), shape (n,)."""
    initial_deg: NDArray[np.float64]
    published_deg: NDArray[np.float64]
    edge_deg: NDArray[np.float64]
    optimal_deg: NDArray[np.float64]
    """Angle of the two lines, smallest feasible angle, and angle of least current sum (electrical deg), shape
    (n,)."""
    initial_current_sum_a: NDArray[np.float64]
    optimal_current_sum_a: NDArray[np.float64]
    """Sum of current magnitudes at the initial and the optimal angle (A), shape (n,)."""
    initial_input_w: NDArray[np.float64]
    optimal_input_w: NDArray[np.float64]
    """Net input power (W), shape (n,)."""
    initial_ripple_percent: NDArray[np.float64]
    optimal_ripple_percent: NDArray[np.float64]
    """Torque ripple, peak to peak over mean (%), shape (n,)."""

    @property
    def current_saving_percent(self) -> NDArray[np.float64]:
        """What the optimal angle saves of the current sum, shape (n,) (%)."""
        return 100.0 * (1.0 - self.optimal_current_sum_a / self.initial_current_sum_a)

    @property
    def power_saving_percent(self) -> NDArray[np.float64]:
        """What it saves of the net input power, shape (n,) (%)."""
        return 100.0 * (1.0 - self.optimal_input_w / self.initial_input_w)


def line_angle(line: tuple[float, float], speed_rpm: float) -> float:
    """Return the initial angle of a line above base speed (paper, Fig. 3)."""
    return min(line[0] + line[1] * (speed_rpm - reference_drive().rating.base_speed_rpm), 90.0)


@cache
def input_current_sweep() -> InputCurrentSweep:
    """Compute the steady states of 1.5 kW over the sweep's speeds."""
    sweep = load_power_sweep(SWEEP)
    drive = ideal_drive()
    rows = []
    for speed_rpm in sweep.speeds_rpm:
        speed = speed_rpm * RADIANS_PER_RPM
        torque = sweep.torque_at(speed_rpm)
        initial_deg = line_angle(INITIAL_LINE, speed_rpm)
        initial = point_at_torque(drive, speed, math.radians(initial_deg), torque)
        least = least_current_sum(drive, speed, torque)
        optimal = point_at_torque(drive, speed, least.advance, torque)
        rows.append(
            (
                speed_rpm,
                initial_deg,
                line_angle(PUBLISHED_LINE, speed_rpm),
                math.degrees(feasible_edge(drive, speed, torque)),
                math.degrees(least.advance),
                initial.current_sum,
                optimal.current_sum,
                initial.input_power,
                optimal.input_power,
                100.0 * (initial.torque_highest - initial.torque_lowest) / initial.torque,
                100.0 * (optimal.torque_highest - optimal.torque_lowest) / optimal.torque,
            )
        )
    columns = np.array(rows).T
    return InputCurrentSweep(sweep.power_w, *columns)


TITLE = "Initial against optimal angle (Figs. 3 and 7)"


def alternative(data: InputCurrentSweep) -> str:
    """Describe the figure in words, for who cannot see it."""
    current, power = data.current_saving_percent, data.power_saving_percent
    return (
        f"From {data.speed_rpm[0]:.0f} to {data.speed_rpm[-1]:.0f} rpm the optimal angle lies below the initial "
        f"one, on or near the edge of what is feasible. It lowers the current sum by {current.min():.1f} to "
        f"{current.max():.1f} %, and the net input power by {power.min():.2f} to {power.max():.2f} %."
    )


def caption(data: InputCurrentSweep) -> str:
    """State what the figure shows."""
    return (
        f"Steady states of {data.power_w / 1000.0:g} kW with ideal current regulators and no core loss. Top: the "
        f"initial angle, {INITIAL_LINE[0]:g}° + {INITIAL_LINE[1]:g}°/rpm above base speed, and the angle of least "
        f"Σ|i|, over the region that is out of reach; the published line ({PUBLISHED_LINE[1]:g}°/rpm from 0°) is "
        "dotted where it lies inside that region. Middle: Σ|i|, what Fig. 7 shows. Bottom: the net power taken "
        "from the supply. The axes of the lower two do not begin at zero."
    )


def draw(data: InputCurrentSweep) -> Figure:
    """Draw angles, current sums and watts over speed."""
    figure, panels = new_figure(7.6, 3, (1.15, 1.0, 1.0))
    _draw_angles(panels[0], data)
    _draw_pair(panels[1], data.speed_rpm, data.initial_current_sum_a, data.optimal_current_sum_a, "Σ|i| (A)")
    saved = data.current_saving_percent
    text = f"optimal angle: {saved.min():.1f} to {saved.max():.1f} % less current"
    label(panels[1], 1400.0, 66.0, text, BLUE, ha="center")
    _draw_pair(panels[2], data.speed_rpm, data.initial_input_w, data.optimal_input_w, "net input power (W)")
    saved = data.power_saving_percent
    text = f"optimal angle: {saved.min():.1f} to {saved.max():.1f} % fewer watts"
    label(panels[2], 1400.0, 1600.0, text, BLUE, ha="center")
    for panel in panels:
        panel.set_xlabel("speed (rpm)")
        panel.set_xlim(520.0, 2230.0)
        panel.set_xticks(np.arange(600.0, 2001.0, 200.0))
    return figure


def _draw_angles(panel: Axes, data: InputCurrentSweep) -> None:
    speeds = data.speed_rpm
    out_of_reach = data.published_deg < data.edge_deg
    panel.fill_between(speeds, 0.0, data.edge_deg, color=GREY, alpha=0.18, linewidth=0)
    text = f"{data.power_w / 1000.0:g} kW out of reach within the current limit"
    label(panel, 1400.0, 11.0, text, GREY, ha="center")
    panel.plot(speeds, data.initial_deg, color=VERMILION)
    panel.plot(speeds, data.optimal_deg, color=BLUE)
    panel.plot(speeds, np.where(out_of_reach, np.nan, data.published_deg), color=GREEN, linewidth=1.3)
    panel.plot(
        speeds, np.where(out_of_reach, data.published_deg, np.nan), color=GREEN, linewidth=1.3, linestyle=":"
    )
    end = float(speeds[-1]) + 15.0
    label(panel, end, data.initial_deg[-1], "initial", VERMILION, va="center", weight="bold")
    label(panel, end, data.optimal_deg[-1], "optimal", BLUE, va="center", weight="bold")
    label(panel, end, data.published_deg[-1], "published\nline", GREEN, va="center")
    panel.set_ylabel("advance angle (el. deg)")
    panel.set_ylim(0.0, 94.0)


def _draw_pair(
    panel: Axes,
    speed_rpm: NDArray[np.float64],
    initial: NDArray[np.float64],
    optimal: NDArray[np.float64],
    quantity: str,
) -> None:
    panel.plot(speed_rpm, initial, color=VERMILION)
    panel.plot(speed_rpm, optimal, color=BLUE)
    end = float(speed_rpm[-1]) + 15.0
    label(panel, end, initial[-1], "initial", VERMILION, va="center", weight="bold")
    label(panel, end, optimal[-1], "optimal", BLUE, va="center", weight="bold")
    panel.set_ylabel(quantity)
    panel.margins(y=0.12)
