"""Maps over speed and torque, one for each candidate and quantity, with one scale for all candidates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.comparison import POINTS
from drivegate.contracts.drawings import SpeedLoadMap
from drivegate_reports.comparison.cells import name, written
from drivegate_reports.comparison.curves import solved_points
from drivegate_reports.comparison.inks import Ink
from drivegate_reports.page.style import GREY, WIDTH_INCH, ink

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS: Final = 2
_NEWTON_METRES: Final = "torque (N·m)"
_STEPS: Final = 8
_SHOWN_SHARE: Final = 0.93


@dataclass(frozen=True)
class CandidateMap:
    """A candidate's values over speed and load."""

    speed_rpm: NDArray[np.float64]
    """Speeds (rpm), shape (n,)."""
    torque_nm: NDArray[np.float64]
    """Torque of each load at each speed (N·m), shape (m, n)."""
    values: NDArray[np.float64]
    """The quantity; NaN where it is not known, shape (m, n)."""
    lost: NDArray[np.bool_]
    """Whether the point was not held, shape (m, n)."""


def candidate_map(document: Mapping[str, Any], candidate: str, key: str) -> CandidateMap:
    """Lay a candidate's operating points out over speed and load."""
    rows, best = document["tables"][POINTS], solved_points(document)
    speeds = sorted({row["speed_rpm"] for row in best})
    loads = sorted({row["load_percent"] for row in best})
    torque = np.full((len(loads), len(speeds)), np.nan)
    values, lost = torque.copy(), np.zeros(torque.shape, np.bool_)
    for row in best:
        torque[loads.index(row["load_percent"]), speeds.index(row["speed_rpm"])] = row["torque_nm"]
    for row in rows:
        if row["candidate"] != candidate:
            continue
        place = loads.index(row["load_percent"]), speeds.index(row["speed_rpm"])
        lost[place] = not row["held"]
        if row["held"] and row[key] is not None:
            values[place] = row[key]
    return CandidateMap(np.array(speeds), torque, values, lost)


def draw_map(document: Mapping[str, Any], inks: Mapping[str, Ink], quantity: SpeedLoadMap) -> Figure:
    """Draw one quantity for all candidates."""
    from matplotlib.figure import Figure as NewFigure

    maps = {candidate: candidate_map(document, candidate, quantity.key) for candidate in inks}
    levels = _levels(maps)
    rows = -(-len(maps) // _COLUMNS)
    figure = NewFigure(figsize=(WIDTH_INCH, 0.5 + 2.2 * rows), layout="constrained")
    axes = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True, sharey=True)
    panels = list(axes.flat)
    mesh: Any = None
    for panel, (candidate, drawn) in zip(panels, maps.items(), strict=False):
        mesh = _draw_panel(panel, drawn, levels)
        _draw_edge(panel, document)
        panel.set_title(inks[candidate].label, color=ink(inks[candidate].colour))
    for panel in panels[len(maps) :]:
        panel.set_visible(False)
    for place in range(len(maps)):
        if place % _COLUMNS == 0:
            panels[place].set_ylabel(_NEWTON_METRES)
        if place + _COLUMNS >= len(maps):
            panels[place].set_xlabel("speed (rpm)")
            panels[place].tick_params(labelbottom=True)
    if mesh is not None:
        bar = figure.colorbar(mesh, ax=axes, label=quantity.scale, shrink=0.9, aspect=30, ticks=levels)
        # As shapes, not as an image, which the page's policy would not let in.
        if bar.solids is not None:
            bar.solids.set_rasterized(False)
        bar.outline.set_visible(False)
    return figure


def _levels(maps: Mapping[str, CandidateMap]) -> NDArray[np.float64]:
    """Choose round steps of the scale that hold all but the outermost values, which get the last colours."""
    from matplotlib.ticker import MaxNLocator

    known = np.concatenate([drawn.values[np.isfinite(drawn.values)] for drawn in maps.values()])
    if not known.size:
        return np.array([0.0, 1.0])
    high = max(float(np.quantile(known, _SHOWN_SHARE)), 1e-3)
    return np.asarray(MaxNLocator(_STEPS).tick_values(0.0, high), np.float64)


def _draw_panel(panel: Axes, drawn: CandidateMap, levels: NDArray[np.float64]) -> Any:
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    speeds = _borders(drawn.speed_rpm)
    # Loads are shares of one power, so that their borders are too.
    shares = _borders(drawn.torque_nm[:, 0] / drawn.torque_nm[-1, 0])
    full = drawn.torque_nm[-1, 0] * drawn.speed_rpm[0]
    torques = np.outer(shares, full / speeds)
    colours = colormaps["cividis_r"]
    panel.grid(visible=False)
    mesh = panel.pcolormesh(
        np.tile(speeds, (len(shares), 1)),
        torques,
        np.ma.masked_invalid(drawn.values),
        norm=BoundaryNorm(levels.tolist(), colours.N, extend="both"),
        cmap=colours,
    )
    if min(drawn.values.shape) > 1 and np.isfinite(drawn.values).sum() > 3:
        panel.contour(
            np.tile(drawn.speed_rpm, (len(drawn.torque_nm), 1)),
            drawn.torque_nm,
            np.ma.masked_invalid(drawn.values),
            levels=levels.tolist(),
            colors="white",
            linewidths=0.9,
        )
    columns = np.nonzero(drawn.lost)[1]
    panel.plot(
        drawn.speed_rpm[columns],
        drawn.torque_nm[drawn.lost],
        "x",
        color=ink(GREY),
        markersize=5,
    )
    return mesh


def _draw_edge(panel: Axes, document: Mapping[str, Any]) -> None:
    edge = document["tables"].get("envelope", ())
    if not edge:
        return
    panel.plot(
        [row["speed_rpm"] for row in edge], [row["torque_nm"] for row in edge], color=ink(GREY), linewidth=1.2
    )
    panel.set_ylim(bottom=0.0)
    slowest, fastest = edge[0]["speed_rpm"], edge[-1]["speed_rpm"]
    padding = 0.03 * (fastest - slowest) + 1.0
    panel.set_xlim(slowest - padding, fastest + padding)


def _borders(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Put borders halfway between points; the outer ones on the outermost points."""
    if len(centres) == 1:
        return np.array([0.95 * centres[0], 1.05 * centres[0]])
    return np.concatenate((centres[:1], 0.5 * (centres[1:] + centres[:-1]), centres[-1:]))


def map_words(document: Mapping[str, Any], inks: Mapping[str, Ink], quantity: SpeedLoadMap) -> str:
    """Describe a map in words."""
    described = []
    for candidate in inks:
        drawn = candidate_map(document, candidate, quantity.key)
        known = drawn.values[np.isfinite(drawn.values)]
        if known.size:
            low, high = (written(float(value), quantity.digits) for value in (known.min(), known.max()))
            where = f"from {low} to {high}"
        else:
            where = "not known anywhere"
        lost = int(drawn.lost.sum())
        described.append(f"{name(candidate)} {where}" + (f", {lost} points not held" if lost else ""))
    return f"Map of {quantity.scale} over speed and torque: {'; '.join(described)}."
