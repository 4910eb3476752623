"""What a PM AC drive can do over speed, whoever controls it: torque with the efficiency below it, and power."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate.contracts.duty.best_operation import known_map
from drivegate_reports.conformance.figures.drive_envelope import column, mark_speeds
from drivegate_reports.page.style import BLUE, DASHED, GREY, label_ends, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE: Final = "What the drive can do over speed"
_LEVELS: Final = (70.0, 80.0, 85.0, 90.0, 94.0, 96.0, 98.0)


def alternative(envelope: Mapping[str, Any]) -> str:
    rating, speed = envelope["rating"], column(envelope, "speed_rpm")
    torque, power = column(envelope, "greatest_torque_nm"), column(envelope, "greatest_power_w")
    known = np.isfinite(torque)
    if not known.any():
        return "No torque is within the limits of current and voltage at any speed."
    charted = [
        value
        for row in envelope["efficiency_map"]["efficiency_percent"]
        for value in row
        if value is not None
    ]
    best = f" The efficiency at least loss is at most {max(charted):.4g} %." if charted else ""
    return (
        f"Two panels from {speed[0]:g} to {speed[-1]:g} rpm. The greatest torque falls from {torque[known][0]:.3g} "
        f"to {torque[known][-1]:.3g} N·m and the greatest power is {np.nanmax(power):.4g} W; rated are "
        f"{rating['rated_power_w']:.4g} W from {rating['base_speed_rpm']:g} rpm on.{best}"
    )


def caption(envelope: Mapping[str, Any]) -> str:
    return (
        f"Within {envelope['rating']['current_limit_a']:g} A and the undistorted "
        f"{envelope['undistorted_voltage_v']:.4g} V of a phase; dotted: base speed and the highest of constant power. "
        "Shaded: the efficiency in per cent where the loss of copper and core is least."
    )


def draw(envelope: Mapping[str, Any]) -> Figure:
    figure, panels = new_figure(4.2, 2, (1.6, 1.0), fitted=False, apart=0.12)
    speed, rating = column(envelope, "speed_rpm"), envelope["rating"]
    _draw_efficiency(panels[0], envelope["efficiency_map"])
    rated_power = rating["rated_power_w"] * np.minimum(speed / rating["base_speed_rpm"], 1.0)
    for panel, most, rated in (
        (panels[0], column(envelope, "greatest_torque_nm"), column(envelope, "rated_torque_nm")),
        (panels[1], column(envelope, "greatest_power_w"), rated_power),
    ):
        panel.plot(speed, most, color=BLUE, marker=".", markersize=4)
        panel.plot(speed, rated, color=GREY, linewidth=1.3, linestyle=DASHED)
        mark_speeds(panel, rating, float(speed[-1]), 1.2)
        panel.set_ylim(0.0, 1.07 * float(np.nanmax([*most, *rated])))
        ends = [("most", float(most[-1]), BLUE), ("rated", float(rated[-1]), GREY)]
        label_ends(panel, 1.012 * float(speed[-1]), *(end for end in ends if np.isfinite(end[1])))
    panels[0].tick_params(labelbottom=False)
    panels[0].set_ylabel("torque (N·m)")
    panels[1].set_ylabel("power (W)")
    panels[1].set_xlabel("speed (rpm)")
    return figure


def _draw_efficiency(panel: Axes, charted: Mapping[str, Any]) -> None:
    speeds, torques, values = known_map(charted)
    if not values:
        return
    panel.contourf(speeds, torques, values, levels=(0.0, *_LEVELS, 100.0), cmap="Greens", alpha=0.4)
    lines = panel.contour(speeds, torques, values, levels=_LEVELS, colors="#00664B", linewidths=0.7)
    for written in panel.clabel(lines, fontsize=9, fmt="%g"):
        written.set_rotation(0.0)
