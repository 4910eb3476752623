"""Curves of the comparison page: differences with intervals, over speed, after disturbances, over a drive cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate.contracts.comparison import POINTS
from drivegate_reports.comparison.inks import Ink, legend_below
from drivegate_reports.comparison.sheets import is_real
from drivegate_reports.page.style import GREY, WIDTH_INCH, ink, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHOWN_BEFORE: Final = 0.1
_SHOWN_AFTER: Final = 0.6
_USUAL_HELD_RPM: Final = 5.0
_USUAL_CHANGE_S: Final = 10.0
# In units of k1, from which on the axis is logarithmic.
_ERROR_TICKS: Final = (-200.0, -40.0, -10.0, -3.0, -1.0, 0.0, 1.0, 3.0, 10.0, 40.0, 200.0)


@dataclass(frozen=True)
class DifferencePanel:
    """The differences in one quantity."""

    label: str
    """What is compared, with its unit."""
    rows: tuple[Mapping[str, Any], ...]
    """Differences of the first candidate less another one, in the order of the ranking."""


def measured_differences(
    document: Mapping[str, Any], declared: Sequence[tuple[str, str, str, str]]
) -> list[DifferencePanel]:
    """Collect the differences from the first candidate that have an interval."""
    ranked = [row["candidate"] for row in document["tables"]["ranking"] if row["rank"] is not None]
    known = [
        row
        for row in document["tables"]["differences"]
        if row["first"] == ranked[0] and row["low"] is not None
    ]
    return [
        DifferencePanel(f"{title} ({unit})", rows)
        for where, key, title, unit in declared
        if (rows := tuple(row for row in known if row["where"].startswith(where) and row["quantity"] == key))
    ]


def draw_differences(panels: Sequence[DifferencePanel], inks: Mapping[str, Ink]) -> Figure:
    """Draw means and intervals of how much more others have than the first."""
    most = max(len(panel.rows) for panel in panels)
    figure, axes = new_figure(len(panels) * (0.75 + 0.26 * most), len(panels))
    for panel, axis in zip(panels, axes, strict=True):
        looks = [inks[row["second"]] for row in panel.rows]
        for place, (row, look) in enumerate(zip(panel.rows, looks, strict=True)):
            axis.plot([-row["high"], -row["low"]], [place, place], color=look.colour, linewidth=2.2)
            fill = look.colour if is_real(row) else "white"
            mark: dict[str, Any] = {"color": look.colour, "markerfacecolor": fill, "markersize": 7}
            axis.plot([-row["mean_difference"]], [place], look.marker, **mark)
        axis.axvline(0.0, color=ink(GREY), linewidth=1.0)
        axis.set_yticks(range(len(looks)), [look.label for look in looks])
        for tick, look in zip(axis.get_yticklabels(), looks, strict=True):
            tick.set_color(ink(look.colour))
        axis.set_ylim(len(looks) - 0.4, -0.6)
        axis.set_xlabel(panel.label)
        axis.grid(visible=False, axis="y")
        axis.margins(x=0.08)
    return figure


def loads_shown(document: Mapping[str, Any]) -> tuple[float, float]:
    """Choose the loads that curves over speed are drawn at."""
    loads = {row["load_percent"] for row in solved_points(document)}
    return min(loads, key=lambda load: abs(load - 50.0)), max(loads)


def solved_points(document: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    """Return a row for each operating point: the best possible where the document has it."""
    tables = document["tables"]
    found: Sequence[Mapping[str, Any]] = tables.get("best_possible", tables[POINTS])
    return found


def draw_over_speed(
    document: Mapping[str, Any],
    inks: Mapping[str, Ink],
    loads: Sequence[float],
    panels: Sequence[tuple[str, str, str]],
) -> Figure:
    """Draw figures of operating points over speed, a column for each load."""
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(WIDTH_INCH, 2.7 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), len(loads), squeeze=False, sharex=True)
    for column, load in enumerate(loads):
        best = [row for row in solved_points(document) if _at(row, load) and row.get("feasible", True)]
        for row_of_axes, (key, words, best_key) in zip(axes, panels, strict=True):
            axis = row_of_axes[column]
            if best_key:
                speeds = [row["speed_rpm"] for row in best]
                axis.plot(speeds, [row[best_key] for row in best], color=GREY, linewidth=3.5, alpha=0.55)
                axis.set_ylim(bottom=0.0)
            _plot_candidates(axis, document, inks, load, key)
            if column == 0:
                axis.set_ylabel(words)
        axes[0][column].set_title(f"{load:g} % of rated power")
        axes[0][column].margins(x=0.05)
        axes[-1][column].set_xlabel("speed (rpm)")
    legend_below(figure, [(look.label, look.style) for look in inks.values()])
    return figure


def _plot_candidates(
    axis: Axes, document: Mapping[str, Any], inks: Mapping[str, Ink], load: float, key: str
) -> None:
    for candidate, look in inks.items():
        rows = [row for row in document["tables"][POINTS] if row["candidate"] == candidate and _at(row, load)]
        axis.plot(
            [row["speed_rpm"] for row in rows],
            [np.nan if not row["held"] or row[key] is None else row[key] for row in rows],
            **look.style,
        )


def _at(row: Mapping[str, Any], load: float) -> bool:
    return abs(float(row["load_percent"]) - load) < 1e-6


def held_rpm(document: Mapping[str, Any]) -> float:
    """k1: the speed error within which a speed counts as held (rpm)."""
    return float(document["drive"].get("speed_tolerance_rpm", _USUAL_HELD_RPM))


def change_s(document: Mapping[str, Any]) -> float:
    """Time at which a disturbance comes (s)."""
    return float(document["drive"].get("change_s", _USUAL_CHANGE_S))


def draw_run(
    document: Mapping[str, Any], inks: Mapping[str, Ink], run: str, declared: Sequence[tuple[str, str]]
) -> Figure:
    """Draw what follows a disturbance, all candidates overlaid."""
    held, change = held_rpm(document), change_s(document)
    begin, end = change - _SHOWN_BEFORE * change, change + _SHOWN_AFTER * change
    figure, panels = new_figure(5.6, len(declared), (1.2, *(1.0,) * (len(declared) - 1)))
    entries = [
        entry for entry in document["trajectories"] if entry["run"] == run and entry["candidate"] in inks
    ]
    for entry in entries:
        look = inks[entry["candidate"]]
        times = np.array(entry["time_s"])
        shown = (times >= begin) & (times <= end)
        for panel, (key, _) in zip(panels, declared, strict=True):
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
    for panel, (_, words) in zip(panels, declared, strict=True):
        panel.set_ylabel(words)
        panel.set_xlim(begin, end)
    panels[-1].set_xlabel("time (s)")
    legend_below(
        figure, [(look.label, look.style) for look in (inks[entry["candidate"]] for entry in entries)]
    )
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
