"""What a PM AC drive can do as a figure: over speed, in the plane of d and q current, and its efficiency."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.duty.efficiency import known_map
from drivegate.output.legend import legend_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

_LEVELS: Final = (60.0, 70.0, 80.0, 85.0, 90.0, 92.0, 94.0, 95.0, 96.0, 97.0, 98.0, 99.0, 100.0)
_ROOM: Final = 1.08


def draw_plane_and_map(figure: SubFigure, document: dict[str, Any]) -> None:
    """Draw the plane of d and q current, and the efficiency map below it."""
    plane, charted = figure.subplots(2, 1)
    _draw_plane(plane, document)
    _draw_map(charted, document)


def _draw_plane(axes: Axes, document: dict[str, Any]) -> None:
    from matplotlib.patches import Circle

    known, limit = document["trajectories"], document["rating"]["current_limit_a"]
    axes.add_patch(Circle((0.0, 0.0), limit, fill=False, color="tab:gray", label="current limit"))
    for row, style in zip(known["voltage_limits"], ("--", ":"), strict=True):
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
    legend_beside(axes)


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
