"""The signals of one run of a candidate, with where it was judged and what the plant could do there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.current.words import RunSignals, judged_point
from drivegate_cases.scenario.load import ConstantPowerLoad
from drivegate_reports.conformance.figures.run_panels import (
    LABELS_AT,
    finish_run_panels,
    new_run_panels,
)
from drivegate_reports.page.style import BLUE, DASHED, GREEN, GREY, VERMILION, label_ends

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_JUDGED: Final = "#F4E3C1"
_STANDS_RPM: Final = 1.0
_SLOW_SHARE: Final = 0.5


def alternative(signals: RunSignals) -> str:
    error = signals.speed_error_rpm
    return (
        f"Four panels over {signals.scenario.duration_s:g} s. The speed error lies between {error.min():.3g} and "
        f"{error.max():.3g} rpm and ends at {error[-1]:.3g} rpm. The advance angle goes from "
        f"{signals.advance_deg[0]:.1f}° to {signals.advance_deg[-1]:.1f}°. Σ|i| ends at "
        f"{signals.current_sum_a[-1]:.1f} A, the current reference at "
        f"{signals.current_reference_a[-1]:.1f} A. The torque ends at {signals.torque_nm[-1]:.2f} N·m, the load at "
        f"{signals.load_torque_nm[-1]:.2f} N·m. Judged from {signals.judged_s[0]:.2f} s to "
        f"{signals.judged_s[1]:.2f} s."
    )


def draw(signals: RunSignals) -> Figure:
    figure, panels = new_run_panels()
    _draw_speed(panels[0], signals)
    _draw_angle(panels[1], signals)
    _draw_currents(panels[2], signals)
    _draw_torque(panels[3], signals)
    for panel in panels:
        panel.axvspan(*signals.judged_s, color=_JUDGED, alpha=0.55, linewidth=0, zorder=0)
    finish_run_panels(panels, signals.scenario.duration_s)
    middle = 0.5 * (signals.judged_s[0] + signals.judged_s[1])
    panels[0].annotate(
        "judged here", (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", fontsize=8.5
    )
    return figure


def _end_labels(panel: Axes, signals: RunSignals, *lines: tuple[str, float, str]) -> None:
    label_ends(panel, LABELS_AT * signals.scenario.duration_s, *lines)


def _draw_speed(panel: Axes, signals: RunSignals) -> None:
    panel.plot(signals.time_s, signals.speed_reference_rpm, color=GREY, linewidth=1.2, linestyle=DASHED)
    panel.plot(signals.time_s, signals.speed_rpm, color=BLUE, linewidth=1.4)
    panel.set_ylabel("speed (rpm)")
    if np.ptp(panel.get_ylim()) < 20.0:
        middle = float(np.mean(panel.get_ylim()))
        panel.set_ylim(middle - 10.0, middle + 10.0)
    ends = signals.speed_reference_rpm[-1], signals.speed_rpm[-1]
    name = "stalled" if abs(ends[1]) < _STANDS_RPM < ends[0] else "speed"
    _end_labels(panel, signals, ("reference", ends[0], GREY), (name, ends[1], BLUE))


def _draw_angle(panel: Axes, signals: RunSignals) -> None:
    panel.step(signals.time_s, signals.advance_deg, where="mid", color=BLUE, linewidth=1.4)
    lines = [("angle", float(signals.advance_deg[-1]), BLUE)]
    point = judged_point(signals)
    if point is not None:
        reach = [max(point.begins_s, 0.0), signals.judged_s[1]]
        panel.plot(reach, [point.edge_deg] * 2, color=VERMILION, linewidth=1.2, linestyle=DASHED)
        lines.append(("feasible edge", point.edge_deg, VERMILION))
        if point.best_deg - point.edge_deg > 1.0:
            panel.plot(reach, [point.best_deg] * 2, color=GREEN, linewidth=1.2, linestyle=DASHED)
            lines.append(("least Σ|i|", point.best_deg, GREEN))
    panel.set_ylabel("angle (el. deg)")
    _end_labels(panel, signals, *lines)


def _draw_currents(panel: Axes, signals: RunSignals) -> None:
    panel.plot(signals.time_s, signals.current_sum_a, color=BLUE, linewidth=1.4)
    panel.plot(signals.time_s, signals.current_reference_a, color=GREEN, linewidth=1.2)
    panel.set_ylabel("current (A)")
    ends = float(signals.current_sum_a[-1]), float(signals.current_reference_a[-1])
    _end_labels(panel, signals, ("Σ|i|", ends[0], BLUE), ("reference", ends[1], GREEN))


def _draw_torque(panel: Axes, signals: RunSignals) -> None:
    panel.plot(signals.time_s, signals.torque_nm, color=BLUE, linewidth=1.2)
    load = meaningful_load(signals)
    panel.plot(signals.time_s, load, color=GREY, linewidth=1.2, linestyle=DASHED)
    panel.set_ylabel("torque (N·m)")
    lines = [("motor", float(signals.torque_nm[-1]), BLUE)]
    if np.isfinite(load[-1]):
        lines.append(("load", float(load[-1]), GREY))
    _end_labels(panel, signals, *lines)


def meaningful_load(signals: RunSignals) -> NDArray[np.float64]:
    """Leave out the load at constant power, shape (n,) (N·m), where the shaft is too slow for it to mean anything."""
    load = signals.load_torque_nm
    if not isinstance(signals.scenario.load, ConstantPowerLoad):
        return load
    return np.where(signals.speed_rpm < _SLOW_SHARE * signals.speed_reference_rpm, np.nan, load)
