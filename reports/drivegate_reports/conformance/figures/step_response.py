"""A step of the torque reference, control period by control period, with overshoot and rise time marked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.results.sections import StepSection
from drivegate_cases.documents.wording import figure
from drivegate_reports.page.style import (
    BLUE,
    DASHED,
    GREEN,
    GREY,
    VERMILION,
    label,
    label_ends,
    leave_room_for_labels,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE: Final = "Step of the torque reference"
_WITH_LABELS: Final = 1.25


def alternative(step: StepSection) -> str:
    share = f"{step.reached_percent:.3g} %"
    risen = (
        f"{share} is not reached"
        if step.rise_ms is None
        else f"{share} is reached after {step.rise_ms:.4g} ms"
    )
    return (
        f"Two panels over {step.time_ms[-1]:.3g} ms. The torque goes from {step.before_nm:.4g} to "
        f"{step.after_nm:.4g} N·m: {risen}, and it overshoots by {figure(step.overshoot_percent)} % of the step. "
        f"Below, the currents of the rotor frame end at {step.direct_current_a[-1]:.3g} A and "
        f"{step.quadrature_current_a[-1]:.3g} A."
    )


def caption(step: StepSection) -> str:
    return (
        f"The step with the least margin, at {step.speed_rpm:g} rpm: means over control periods, currents at their "
        f"ends. Allowed are {step.allowed_ms:.3g} ms to {step.reached_percent:.3g} % and an overshoot of "
        f"{step.overshoot_limit_percent:.3g} %, the shaded band."
    )


def draw(step: StepSection) -> Figure:
    drawn, panels = new_figure(3.6, 2, (1.4, 1.0), fitted=False, apart=0.14)
    _draw_torque(panels[0], step)
    _draw_currents(panels[1], step)
    begin, end = step.time_ms[0], step.time_ms[-1]
    for panel in panels:
        panel.axvline(0.0, color=GREY, linewidth=0.8)
        leave_room_for_labels(panel, end, begin, _WITH_LABELS)
    panels[0].tick_params(labelbottom=False)
    panels[1].set_xlabel("time since the step (ms)")
    return drawn


def _draw_torque(panel: Axes, step: StepSection) -> None:
    size, end = step.after_nm - step.before_nm, step.time_ms[-1]
    wanted = [step.before_nm, step.before_nm, step.after_nm, step.after_nm]
    panel.plot([step.time_ms[0], 0.0, 0.0, end], wanted, color=GREY, linewidth=1.2, linestyle=DASHED)
    limit = step.after_nm + 0.01 * step.overshoot_limit_percent * size
    panel.fill_between([0.0, end], step.after_nm, limit, color=GREEN, alpha=0.14, linewidth=0)
    panel.plot(step.time_ms, step.torque_nm, color=BLUE, linewidth=1.4)
    panel.margins(y=0.16)
    ends = [("reference", step.after_nm, GREY), ("motor", step.torque_nm[-1], BLUE)]
    behind = [torque for time, torque in zip(step.time_ms, step.torque_nm, strict=True) if time > 0.0]
    furthest = max(behind, key=lambda torque: torque * size)
    if step.overshoot_percent > 0.0:
        ends.append((f"overshoot {figure(step.overshoot_percent)} %", furthest, VERMILION))
        panel.axhline(furthest, color=VERMILION, linewidth=0.8, xmax=1.0 / _WITH_LABELS)
    if step.rise_ms is not None:
        risen = step.before_nm + 0.01 * step.reached_percent * size
        panel.plot([step.rise_ms], [risen], "o", color=VERMILION, markersize=4)
        low, high = panel.get_ylim()
        below = risen - 0.1 * (high - low) * (1.0 if size > 0.0 else -1.0)
        words = f"{step.reached_percent:.3g} % in {step.rise_ms:.4g} ms"
        label(panel, step.rise_ms + 0.02 * end, below, words, VERMILION, va="center")
    panel.set_ylabel("torque (N·m)")
    label_ends(panel, 1.012 * end, *ends)


def _draw_currents(panel: Axes, step: StepSection) -> None:
    panel.plot(step.time_ms, step.direct_current_a, color=VERMILION, linewidth=1.3)
    panel.plot(step.time_ms, step.quadrature_current_a, color=BLUE, linewidth=1.3)
    panel.margins(y=0.1)
    panel.set_ylabel("current (A)")
    ends = ("d", step.direct_current_a[-1], VERMILION), ("q", step.quadrature_current_a[-1], BLUE)
    label_ends(panel, 1.012 * step.time_ms[-1], *ends)
