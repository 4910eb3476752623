"""Curves of the comparison page: differences with intervals, over speed, after disturbances, over a drive cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate_reports.comparison.inks import Ink
from drivegate_reports.page.style import GREY, WIDTH_INCH, ink, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS: Final = (
    ("drawn", "input_power_w", "input power, drawn plants", "W"),
    ("drawn", "current_sum_a", "Σ|i|, drawn plants", "A"),
    ("drive cycle", "energy_wh_per_km", "energy, drive cycle", "Wh/km"),
)
_SHOWN_BEFORE: Final = 0.1
_SHOWN_AFTER: Final = 0.6
_USUAL_HELD_RPM: Final = 5.0
_USUAL_CHANGE_S: Final = 10.0
# In units of k1, from which on the axis is logarithmic.
_ERROR_TICKS: Final = (-200.0, -40.0, -10.0, -3.0, -1.0, 0.0, 1.0, 3.0, 10.0, 40.0, 200.0)


@dataclass(frozen=True)
class Measured:
    """A difference from the first candidate."""

    candidate: str
    """The other candidate."""
    mean: float
    low: float
    high: float
    """Other less first, and its interval."""
    is_real: bool
    """Whether it is more than chance and matters."""


@dataclass(frozen=True)
class DifferencePanel:
    """The differences in one quantity."""

    title: str
    unit: str
    """What is compared."""
    rows: tuple[Measured, ...]
    """In the order of the ranking."""


def measured_differences(document: Mapping[str, Any]) -> tuple[DifferencePanel, ...]:
    """Collect the differences from the first candidate that have an interval."""
    ranked = [row["candidate"] for row in document["tables"]["ranking"] if row["rank"] is not None]
    panels = []
    for where, key, title, unit in _PANELS:
        rows = tuple(
            Measured(
                row["second"],
                -row["mean_difference"],
                -row["high"],
                -row["low"],
                row["verdict"] not in ("no real difference", "too few pairs"),
            )
            for row in document["tables"]["differences"]
            if row["where"].startswith(where)
            and row["quantity"] == key
            and row["first"] == ranked[0]
            and row["low"] is not None
        )
        if rows:
            panels.append(DifferencePanel(title, unit, rows))
    return tuple(panels)


def draw_differences(panels: Sequence[DifferencePanel], inks: Mapping[str, Ink]) -> Figure:
    """Draw means and intervals of differences."""
    most = max(len(panel.rows) for panel in panels)
    figure, axes = new_figure(len(panels) * (0.75 + 0.26 * most), len(panels))
    for panel, axis in zip(panels, axes, strict=True):
        for place, row in enumerate(panel.rows):
            look = inks[row.candidate]
            axis.plot([row.low, row.high], [place, place], color=look.colour, linewidth=2.2)
            fill = look.colour if row.is_real else "white"
            axis.plot([row.mean], [place], look.marker, color=look.colour, markerfacecolor=fill, markersize=7)
        axis.axvline(0.0, color=ink(GREY), linewidth=1.0)
        axis.set_yticks(range(len(panel.rows)), [inks[row.candidate].label for row in panel.rows])
        for tick, row in zip(axis.get_yticklabels(), panel.rows, strict=True):
            tick.set_color(ink(inks[row.candidate].colour))
        axis.set_ylim(len(panel.rows) - 0.4, -0.6)
        axis.set_xlabel(f"{panel.title} ({panel.unit})")
        axis.grid(visible=False, axis="y")
        axis.margins(x=0.08)
    return figure


def loads_shown(document: Mapping[str, Any]) -> tuple[float, float]:
    """Choose the loads that curves over speed are drawn at."""
    loads = [100.0 * share for share in document["size"]["shares"]]
    return min(loads, key=lambda load: abs(load - 50.0)), max(loads)


def draw_over_speed(document: Mapping[str, Any], inks: Mapping[str, Ink], loads: Sequence[float]) -> Figure:
    """Draw Σ|i|, and input power above the least, over speed."""
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(WIDTH_INCH, 5.4), layout="constrained")
    axes = figure.subplots(2, len(loads), squeeze=False, sharex=True)
    for column, load in enumerate(loads):
        top, bottom = axes[0][column], axes[1][column]
        best = [row for row in document["tables"]["best_possible"] if _at(row, load) and row["feasible"]]
        speeds = [row["speed_rpm"] for row in best]
        top.plot(speeds, [row["least_current_sum_a"] for row in best], color=GREY, linewidth=3.5, alpha=0.55)
        for candidate, look in inks.items():
            rows = [
                row
                for row in document["tables"]["operating_points"]
                if row["candidate"] == candidate and _at(row, load)
            ]
            x = [row["speed_rpm"] for row in rows]
            style: dict[str, Any] = {
                "color": look.colour,
                "linestyle": look.dash,
                "marker": look.marker,
                "markersize": 4,
            }
            for axis, key in ((top, "current_sum_a"), (bottom, "gap_power_w")):
                y = [np.nan if not row["held"] or row[key] is None else row[key] for row in rows]
                axis.plot(x, y, **style)
        top.set_title(f"{load:g} % of rated power")
        top.set_ylim(bottom=0.0)
        bottom.set_xlabel("speed (rpm)")
        top.margins(x=0.05)
    axes[0][0].set_ylabel("Σ|i| (A)")
    axes[1][0].set_ylabel("power above least (W)")
    _legend(figure, inks)
    return figure


def _at(row: Mapping[str, Any], load: float) -> bool:
    return abs(float(row["load_percent"]) - load) < 1e-6


def _legend(figure: Figure, inks: Mapping[str, Ink]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [], [], color=look.colour, linestyle=look.dash, marker=look.marker, markersize=4, label=look.label
        )
        for look in inks.values()
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(len(handles), 4), frameon=False, fontsize=9.0
    )


def held_rpm(document: Mapping[str, Any]) -> float:
    """k1: the speed error within which a speed counts as held (rpm)."""
    return float(document["drive"].get("speed_tolerance_rpm", _USUAL_HELD_RPM))


def change_s(document: Mapping[str, Any]) -> float:
    """Time at which a disturbance comes (s)."""
    return float(document["drive"].get("change_s", _USUAL_CHANGE_S))


def draw_disturbance(document: Mapping[str, Any], inks: Mapping[str, Ink], run: str) -> Figure:
    """Draw what follows a disturbance, all candidates overlaid."""
    held, change = held_rpm(document), change_s(document)
    begin, end = change - _SHOWN_BEFORE * change, change + _SHOWN_AFTER * change
    figure, panels = new_figure(5.6, 3, (1.2, 1.0, 1.0))
    keys = ("speed_error_rpm", "advance_deg", "current_sum_a")
    entries = [
        entry for entry in document["trajectories"] if entry["run"] == run and entry["candidate"] in inks
    ]
    for entry in entries:
        look = inks[entry["candidate"]]
        times = np.array(entry["time_s"])
        shown = (times >= begin) & (times <= end)
        for panel, key in zip(panels, keys, strict=True):
            panel.plot(
                times[shown],
                np.array(entry[key])[shown],
                color=look.colour,
                linestyle=look.dash,
                linewidth=1.5,
            )
    for level in (-held, held):
        panels[0].axhline(level, color=ink(GREY), linewidth=0.8, linestyle=":")
    panels[0].set_yscale("symlog", linthresh=held, linscale=1.0)
    low, high = panels[0].get_ylim()
    ticks = [tick * held for tick in _ERROR_TICKS if low <= tick * held <= high]
    panels[0].set_yticks(ticks, [f"{tick:g}".replace("-", "−") for tick in ticks])
    panels[0].minorticks_off()
    for panel, words in zip(
        panels, ("speed error (rpm)", "advance angle (el. deg)", "Σ|i| (A)"), strict=True
    ):
        panel.set_ylabel(words)
        panel.set_xlim(begin, end)
    panels[-1].set_xlabel("time (s)")
    _legend(figure, {entry["candidate"]: inks[entry["candidate"]] for entry in entries})
    return figure


def draw_cycle(document: Mapping[str, Any], inks: Mapping[str, Ink]) -> Figure:
    """Draw the drive cycle: speeds, and energy above that of the first candidate."""
    figure, panels = new_figure(4.8, 2, (1.0, 1.1))
    entries = {entry["candidate"]: entry for entry in document["cycle_samples"] if entry["candidate"] in inks}
    ordered = [(candidate, entries[candidate]) for candidate in inks if candidate in entries]
    if not ordered:
        return figure
    first = np.array(ordered[0][1]["energy_wh"])
    panels[0].plot(
        ordered[0][1]["time_s"], ordered[0][1]["speed_reference_km_h"], color=GREY, linewidth=4.0, alpha=0.5
    )
    for candidate, entry in ordered:
        look = inks[candidate]
        panels[0].plot(
            entry["time_s"], entry["speed_km_h"], color=look.colour, linestyle=look.dash, linewidth=1.3
        )
        above = np.array(entry["energy_wh"]) - first
        panels[1].plot(entry["time_s"], above, color=look.colour, linestyle=look.dash, linewidth=1.5)
    end = float(ordered[0][1]["time_s"][-1])
    for candidate, height in _spread(panels[1], ordered, first):
        label(panels[1], 1.01 * end, height, inks[candidate].label, inks[candidate].colour, va="center")
    panels[0].set_ylabel("speed (km/h)")
    panels[1].set_ylabel("energy above first (Wh)")
    panels[1].set_xlabel("time (s)")
    for panel in panels:
        panel.set_xlim(0.0, 1.28 * end)
    return figure


def _spread(
    panel: Axes, ordered: Sequence[tuple[str, Mapping[str, Any]]], first: Any
) -> list[tuple[str, float]]:
    """Place labels at the ends of lines, apart from each other."""
    ends = sorted(
        (float(np.array(entry["energy_wh"])[-1] - first[-1]), candidate) for candidate, entry in ordered
    )
    low, high = panel.get_ylim()
    least = 0.085 * (high - low)
    placed: list[tuple[str, float]] = []
    for height, candidate in ends:
        at = height if not placed else max(height, placed[-1][1] + least)
        placed.append((candidate, at))
    return placed
