"""Currents in the plane of the rotor frame, between the circle of the current limit and ellipses of the voltage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate_reports.page.style import (
    BLUE,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    new_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE: Final = "Currents of the rotor frame between their limits"
_ROOM: Final = 1.08
_FURTHEST: Final = 2.0


@dataclass(frozen=True)
class Way:
    """The way of the currents through a run."""

    title: str
    direct: Sequence[float]
    quadrature: Sequence[float]
    """Currents along and across the magnet's axis (A)."""


def alternative(trajectories: Mapping[str, Any], limit: float, ways: Sequence[Way]) -> str:
    best, most = trajectories["most_torque_per_ampere"][-1], trajectories["greatest_torque"]
    words = [
        f"The plane of d and q current within a circle of {limit:g} A. Most torque per ampere goes from no current to "
        f"{best['direct_a']:.3g} A and {best['quadrature_a']:.3g} A."
    ]
    if most:
        end = most[-1]
        words.append(
            f"The greatest torque moves to {end['direct_a']:.3g} A and {end['quadrature_a']:.3g} A at "
            f"{end['speed_rpm']:.5g} rpm."
        )
    words += [
        f"{way.title}: d current from {min(way.direct):.3g} to {max(way.direct):.3g} A, q current from "
        f"{min(way.quadrature):.3g} to {max(way.quadrature):.3g} A."
        for way in ways
    ]
    return " ".join(words)


def caption(trajectories: Mapping[str, Any]) -> str:
    limits = zip(("dashed", "dotted"), trajectories["voltage_limits"], strict=False)
    ellipses = ", ".join(f"{style} at {row['speed_rpm']:g} rpm" for style, row in limits)
    return (
        f"Circle: the current limit. Ellipses: currents that take the undistorted voltage, {ellipses}. Green: most "
        "torque per ampere. Orange: greatest torque within both limits from where the voltage is used up to overspeed."
    )


def draw(
    trajectories: Mapping[str, Any],
    limit: float,
    ways: Sequence[Way],
    dots: Sequence[tuple[float, float]] = (),
) -> Figure:
    """Draw the limits, what is best, and the ways beside each other; without ways the first alone."""
    figure = new_grid(3.7, 1, max(len(ways), 1))
    reach = _reach(limit, ways)
    for panel in figure.axes:
        _draw_limits(panel, trajectories, limit)
        panel.set_aspect("equal")
        panel.set_xlim(*reach[0])
        panel.set_ylim(*reach[1])
        panel.set_xlabel("d current (A)")
    figure.axes[0].set_ylabel("q current (A)")
    for panel, way in zip(figure.axes, ways, strict=False):
        panel.plot(way.direct, way.quadrature, color=BLUE, linewidth=1.3, zorder=4)
        panel.plot([way.direct[0]], [way.quadrature[0]], ".", color=BLUE, markersize=7, zorder=4)
        panel.set_title(way.title)
    if dots:
        figure.axes[0].plot(*zip(*dots, strict=True), "x", color=PURPLE, markersize=5, zorder=5)
    return figure


def _reach(limit: float, ways: Sequence[Way]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends of both axes: the circle where the magnet can be weakened, and the ways but for the furthest."""
    furthest = _FURTHEST * limit
    direct = [value for way in ways for value in way.direct]
    quadrature = [value for way in ways for value in way.quadrature]
    return (
        (_ROOM * max(min([-limit, *direct]), -furthest), _ROOM * min(max([0.4 * limit, *direct]), furthest)),
        (
            _ROOM * max(min([-limit, *quadrature]), -furthest),
            _ROOM * min(max([limit, *quadrature]), furthest),
        ),
    )


def _draw_limits(panel: Axes, trajectories: Mapping[str, Any], limit: float) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 121)
    panel.plot(limit * np.cos(turn), limit * np.sin(turn), color=GREY, linewidth=1.2)
    for row, style in zip(trajectories["voltage_limits"], (DASHED, DOTTED), strict=False):
        panel.plot(row["direct_a"], row["quadrature_a"], color=VERMILION, linewidth=1.1, linestyle=style)
    for key, colour in (("most_torque_per_ampere", GREEN), ("greatest_torque", ORANGE)):
        rows = trajectories[key]
        panel.plot(
            [row["direct_a"] for row in rows],
            [row["quadrature_a"] for row in rows],
            color=colour,
            linewidth=2.2,
        )
