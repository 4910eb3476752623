"""What the drive can do over speed, whoever controls it: torque, power, angle and ripple."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_reports.page.style import (
    BLUE,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    ORANGE,
    VERMILION,
    label_ends,
    leave_room_for_labels,
    new_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE: Final = "What the drive can do over speed"
_FINE: Final = 8


def column(envelope: Mapping[str, Any], key: str) -> NDArray[np.float64]:
    """Take one quantity at all speeds; NaN where it cannot be had."""
    return np.array(
        [np.nan if point[key] is None else point[key] for point in envelope["points"]], dtype=np.float64
    )


def alternative(envelope: Mapping[str, Any]) -> str:
    rating, speed = envelope["rating"], column(envelope, "speed_rpm")
    torque, power, ripple = (
        column(envelope, key) for key in ("greatest_torque_nm", "greatest_power_w", "ripple_percent")
    )
    words = [
        f"Four panels from {speed[0]:g} to {speed[-1]:g} rpm. At the current limit the greatest torque falls from "
        f"{torque[0]:.3g} to {torque[-1]:.3g} N·m and the greatest power is {np.max(power):.4g} W; rated are "
        f"{rating['rated_power_w']:.4g} W from {rating['base_speed_rpm']:g} rpm on."
    ]
    for key, name in (("edge_deg", "feasible edge"), ("advance_deg", "angle of least Σ|i|")):
        known = column(envelope, key)
        known = known[np.isfinite(known)]
        if known.size:
            words.append(f"The {name} lies between {known.min():.1f}° and {known.max():.1f}°.")
    if np.isfinite(ripple).any():
        worst = int(np.nanargmax(ripple))
        words.append(f"The ripple at least Σ|i| is at most {ripple[worst]:.1f} %, at {speed[worst]:.0f} rpm.")
    return " ".join(words)


def caption(envelope: Mapping[str, Any], ripple_percent: float) -> str:
    limit = "no limit of it is stated"
    if np.isfinite(ripple_percent):
        limit = (
            f"its limit of {ripple_percent:g} % is required at the points named here, and advised elsewhere"
        )
    return (
        f"At {envelope['rating']['current_limit_a']:g} A; dotted: base speed and the highest of constant power. "
        "No controller gives more than the blue lines, nor rated torque at an angle in the shaded part. Ripple: at "
        f"rated power and least Σ|i|, ideal regulator; {limit}."
    )


def draw(envelope: Mapping[str, Any], ripple_percent: float) -> Figure:
    figure = new_grid(3.1, 2, 2)
    panels = figure.axes
    speed, rating = column(envelope, "speed_rpm"), envelope["rating"]
    _draw_torque(panels[0], envelope, speed)
    _draw_power(panels[1], envelope, speed)
    _draw_angle(panels[2], envelope, speed)
    _draw_ripple(panels[3], envelope, speed, ripple_percent)
    for panel in panels:
        mark_speeds(panel, rating, float(speed[-1]), 1.4)
    for panel in panels[:2]:
        panel.tick_params(labelbottom=False)
    for panel in panels[2:]:
        panel.set_xlabel("speed (rpm)")
    return figure


def mark_speeds(panel: Axes, rating: Mapping[str, float], highest_rpm: float, share: float) -> None:
    """Mark base speed and the highest of constant power, and leave room for labels behind the last speed."""
    for key in ("base_speed_rpm", "highest_speed_rpm"):
        panel.axvline(rating[key], color=GREY, linewidth=0.8, linestyle=DOTTED)
    leave_room_for_labels(panel, highest_rpm, share=share)


def _draw_torque(panel: Axes, envelope: Mapping[str, Any], speed: NDArray[np.float64]) -> None:
    # Between the speeds power is nearly straight, so that torque is a hyperbola.
    fine = np.unique(np.concatenate([np.linspace(*pair, _FINE) for pair in pairwise(speed)]))
    lines = []
    for key, name, colour, style in (
        ("greatest_torque_nm", "most", BLUE, "-"),
        ("rated_torque_nm", "rated", GREY, DASHED),
        ("torque_without_advance_nm", "most at 0°", VERMILION, "-"),
    ):
        torque = column(envelope, key)
        panel.plot(fine, np.interp(fine, speed, torque * speed) / fine, color=colour, linestyle=style)
        lines.append((name, float(torque[-1]), colour))
    panel.plot(speed, column(envelope, "greatest_torque_nm"), ".", color=BLUE, markersize=4)
    panel.set_ylabel("torque (N·m)")
    _label(panel, speed, *lines)


def _draw_power(panel: Axes, envelope: Mapping[str, Any], speed: NDArray[np.float64]) -> None:
    rating = envelope["rating"]
    rated = rating["rated_power_w"] * np.minimum(speed / rating["base_speed_rpm"], 1.0)
    most = column(envelope, "greatest_power_w")
    drawn = column(envelope, "input_power_w")
    panel.plot(speed, most, color=BLUE, marker=".", markersize=4)
    panel.plot(speed, drawn, color=ORANGE, linewidth=1.3)
    panel.plot([0.0, *speed], [0.0, *rated], color=GREY, linestyle=DASHED)
    panel.set_ylim(bottom=0.0)
    panel.set_ylabel("power (W)")
    lines = [("most", most[-1], BLUE), ("input, rated", drawn[-1], ORANGE), ("rated", rated[-1], GREY)]
    _label(panel, speed, *lines)


def _draw_angle(panel: Axes, envelope: Mapping[str, Any], speed: NDArray[np.float64]) -> None:
    base = envelope["rating"]["base_speed_rpm"]
    edge, best, line = (column(envelope, key) for key in ("edge_deg", "advance_deg", "line_deg"))
    panel.fill_between(speed, 0.0, edge, color=GREY, alpha=0.18, linewidth=0)
    panel.plot(speed, edge, color=GREY, linestyle=DASHED)
    panel.plot(speed, best, color=ORANGE, marker=".", markersize=4)
    # It jumps at base speed, which two speeds would draw as a slope.
    place = int(np.searchsorted(speed, base * (1.0 - 1e-9)))
    panel.plot(np.insert(speed, place, base), np.insert(line, place, 0.0), color=GREEN)
    panel.set_ylim(bottom=0.0)
    panel.set_ylabel("angle (el. deg)")
    _label(
        panel,
        speed,
        ("feasible edge", edge[-1], GREY),
        ("least Σ|i|", best[-1], ORANGE),
        ("line", line[-1], GREEN),
    )


def _draw_ripple(
    panel: Axes, envelope: Mapping[str, Any], speed: NDArray[np.float64], ripple_percent: float
) -> None:
    ripple = column(envelope, "ripple_percent")
    panel.plot(speed, ripple, color=ORANGE, marker=".", markersize=4)
    if np.isfinite(ripple_percent):
        panel.plot([0.0, speed[-1]], [ripple_percent] * 2, color=VERMILION, linewidth=1.2, linestyle=DASHED)
    panel.set_ylim(bottom=0.0)
    panel.set_ylabel("ripple (%)")
    _label(panel, speed, ("least Σ|i|", ripple[-1], ORANGE), ("limit", ripple_percent, VERMILION))


def _label(panel: Axes, speed: NDArray[np.float64], *lines: tuple[str, float, str]) -> None:
    """Label lines at their ends, but for those that end out of reach."""
    known = [(name, float(value), colour) for name, value, colour in lines if np.isfinite(value)]
    label_ends(panel, 1.012 * float(speed[-1]), *known)
