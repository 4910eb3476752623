"""What a drive can do as a figure: torque, power, angle and ripple over speed."""

from __future__ import annotations

from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from drivegate.contracts.duty.best_operation import known_map
from drivegate.output.figures import figure_file, side_legend
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEVELS: Final = (60.0, 70.0, 80.0, 85.0, 90.0, 92.0, 94.0, 95.0, 96.0, 97.0, 98.0, 99.0, 100.0)
_ROOM: Final = 1.08
Panels: TypeAlias = tuple[tuple[str, tuple[tuple[str, str, str, str], ...]], ...]
"""Labels, each with curves: key, name, style and colour."""

_PANELS: Final[Panels] = (
    (
        "torque (N·m)",
        (
            ("greatest_torque_nm", "at the current limit", "-", "tab:blue"),
            ("torque_without_advance_nm", "without advance", ":", "tab:blue"),
            ("rated_torque_nm", "of rated power", "--", "tab:gray"),
        ),
    ),
    (
        "power (W)",
        (
            ("greatest_power_w", "at the current limit", "-", "tab:blue"),
            ("input_power_w", "input at rated power", "-", "tab:orange"),
            ("rated_power_w", "rated", "--", "tab:gray"),
        ),
    ),
    (
        "angle (el. deg)",
        (
            ("line_deg", "recommended line", "-", "tab:green"),
            ("advance_deg", "least Σ|i|", "-", "tab:orange"),
            ("edge_deg", "feasible edge", "--", "tab:red"),
            ("greatest_torque_deg", "greatest torque", ":", "tab:blue"),
        ),
    ),
    ("torque ripple (%)", (("ripple_percent", "at least Σ|i|,\nideal regulator", "-", "tab:orange"),)),
)


_DUTY_PANELS: Final[Panels] = (
    (
        "torque (N·m)",
        (
            ("greatest_torque_nm", "within both limits", "-", "tab:blue"),
            ("rated_torque_nm", "of rated power", "--", "tab:gray"),
        ),
    ),
    (
        "power (W)",
        (
            ("greatest_power_w", "within both limits", "-", "tab:blue"),
            ("rated_power_w", "rated", "--", "tab:gray"),
        ),
    ),
    (
        "current (A)",
        (
            ("direct_a", "d, least current", "-", "tab:red"),
            ("quadrature_a", "q, least current", "-", "tab:orange"),
            ("least_loss_direct_a", "d, least loss", ":", "tab:red"),
            ("greatest_direct_a", "d, greatest torque", "--", "tab:blue"),
        ),
    ),
    (
        "loss (W)",
        (("loss_w", "at least current", "-", "tab:orange"), ("least_loss_w", "least", "--", "tab:green")),
    ),
)


def write_figure(document: dict[str, Any], plot: Path) -> None:
    """Draw what a drive can do; base and highest speed are marked."""
    takes_duty = "undistorted_voltage_v" in document
    with figure_file(plot, 14.0 if takes_duty else 9.0, 9.0) as figure:
        panels, part = _PANELS, figure
        if takes_duty:
            parts: Any = figure.subfigures(1, 2, width_ratios=(9.0, 5.0))
            panels, part = _DUTY_PANELS, parts[0]
            plane, charted = parts[1].subplots(2, 1)
            _draw_plane(plane, document)
            _draw_map(charted, document)
        all_axes = part.subplots(len(panels), 1, sharex=True)
        for axes, (label, curves) in zip(all_axes, panels, strict=True):
            _draw(axes, document, label, curves)
        all_axes[-1].set_xlabel("speed (rpm)")
        figure.suptitle(one_line(f"What {document['drive']} can do"))


def _draw(
    axes: Axes, document: dict[str, Any], label: str, curves: tuple[tuple[str, str, str, str], ...]
) -> None:
    for key, name, style, colour in curves:
        axes.plot(*_curve(document, key), style, label=name, color=colour, linewidth=1.3)
    for key in ("base_speed_rpm", "highest_speed_rpm"):
        axes.axvline(document["rating"][key], color="black", linewidth=0.6, alpha=0.4)
    axes.set_ylabel(label)
    axes.set_xlim(left=0.0)
    axes.grid(visible=True, alpha=0.3)
    side_legend(axes)


def _curve(document: dict[str, Any], key: str) -> tuple[list[float], list[float]]:
    rating, points = document["rating"], document["points"]
    base = rating["base_speed_rpm"]
    speeds = [point["speed_rpm"] for point in points]
    if key == "rated_power_w":
        return speeds, [rating[key] * min(speed / base, 1.0) for speed in speeds]
    values = [nan if point[key] is None else point[key] for point in points]
    if key == "line_deg":
        # It jumps at base speed, which two speeds of the grid would draw as a slope.
        place = speeds.index(base)
        return [*speeds[:place], base, *speeds[place:]], [*values[:place], 0.0, *values[place:]]
    return speeds, values


def _draw_plane(axes: Axes, document: dict[str, Any]) -> None:
    from matplotlib.patches import Circle

    known, limit = document["trajectories"], document["rating"]["current_limit_a"]
    axes.add_patch(Circle((0.0, 0.0), limit, fill=False, color="tab:gray", label="current limit"))
    for row, style in zip(known["voltage_limits"], ("--", ":"), strict=False):
        name = f"voltage limit,\n{row['speed_rpm']:g} rpm"
        axes.plot(row["direct_a"], row["quadrature_a"], style, color="tab:red", linewidth=1.0, label=name)
    for key, name, colour in (
        ("most_torque_per_ampere", "most torque\nper ampere", "tab:green"),
        ("greatest_torque", "greatest torque\nin weakening", "tab:orange"),
    ):
        rows = known[key]
        axes.plot(
            [row["direct_a"] for row in rows], [row["quadrature_a"] for row in rows], color=colour, label=name
        )
    axes.set_aspect("equal")
    axes.set_xlim(-_ROOM * limit, 0.45 * limit)
    axes.set_ylim(-_ROOM * limit, _ROOM * limit)
    axes.set_xlabel("d current (A)")
    axes.set_ylabel("q current (A)")
    axes.grid(visible=True, alpha=0.3)
    side_legend(axes)


def _draw_map(axes: Axes, document: dict[str, Any]) -> None:
    speeds, torques, values = known_map(document["efficiency_map"])
    if values:
        filled = axes.contourf(speeds, torques, values, levels=_LEVELS, extend="min")
        axes.figure.colorbar(filled, ax=axes, label="efficiency at least loss (%)")
    points = document["points"]
    torque = [nan if point["greatest_torque_nm"] is None else point["greatest_torque_nm"] for point in points]
    axes.plot([point["speed_rpm"] for point in points], torque, color="tab:blue", linewidth=1.3)
    axes.set_xlabel("speed (rpm)")
    axes.set_ylabel("torque (N·m)")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
