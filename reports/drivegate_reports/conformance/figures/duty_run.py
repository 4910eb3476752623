"""The signals of one run of a controller of duty ratios: speed, torque, currents and voltage over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.contracts.duty.columns import VOLTAGE
from drivegate.contracts.duty.words import follows_torque, undistorted_v
from drivegate_reports.conformance.figures.run_panels import (
    LABELS_AT,
    finish_run_panels,
    new_run_panels,
)
from drivegate_reports.page.style import BLUE, DASHED, GREEN, GREY, VERMILION, label_ends

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drivegate.contracts.contract import RecordedTrace

CAPTION: Final = (
    "Means over equal stretches of the run. Dashed: references, the current limit, and the undistorted voltage of the "
    "link."
)


def alternative(trace: RecordedTrace) -> str:
    last = {name: float(values[-1]) for name, values in trace.columns.items()}
    return (
        f"Four panels over {trace.scenario.duration_s:g} s. The speed ends at {last['speed_rpm']:.5g} rpm, "
        f"the torque at {last['torque_nm']:.4g} N·m. The currents of the rotor's frame end at "
        f"{last['direct_current_a']:.4g} A and {last['quadrature_current_a']:.4g} A, the voltage at "
        f"{last[VOLTAGE]:.4g} V of {undistorted_v(trace)[-1]:.4g} V."
    )


def draw(trace: RecordedTrace) -> Figure:
    figure, panels = new_run_panels()
    _draw_speed(panels[0], trace)
    _draw_torque(panels[1], trace)
    _draw_currents(panels[2], trace)
    _draw_voltage(panels[3], trace)
    finish_run_panels(panels, trace.scenario.duration_s)
    return figure


def _draw(panel: Axes, trace: RecordedTrace, *lines: tuple[str, str, str, bool]) -> None:
    """Draw columns, each with a label at its end: column, label, colour, and whether it is dashed."""
    time = trace.columns["time_s"]
    for column, _, colour, dashed in lines:
        style = DASHED if dashed else "-"
        panel.plot(time, trace.columns[column], color=colour, linestyle=style, linewidth=1.3)
    ends = [(label, float(trace.columns[column][-1]), colour) for column, label, colour, _ in lines]
    label_ends(panel, LABELS_AT * trace.scenario.duration_s, *ends)


def _draw_speed(panel: Axes, trace: RecordedTrace) -> None:
    name = "held" if follows_torque(trace) else "reference"
    _draw(panel, trace, ("speed_reference_rpm", name, GREY, True), ("speed_rpm", "speed", BLUE, False))
    panel.set_ylabel("speed (rpm)")


def _draw_torque(panel: Axes, trace: RecordedTrace) -> None:
    wanted = ("torque_reference_nm", "reference") if follows_torque(trace) else ("load_torque_nm", "load")
    _draw(panel, trace, (*wanted, GREY, True), ("torque_nm", "motor", BLUE, False))
    panel.set_ylabel("torque (N·m)")


def _draw_currents(panel: Axes, trace: RecordedTrace) -> None:
    lines = (
        ("direct_current_a", "d", VERMILION),
        ("quadrature_current_a", "q", BLUE),
        ("peak_current_a", "peak", GREEN),
    )
    _draw(panel, trace, *((*line, False) for line in lines))
    limit = trace.scenario.drive.rating.current_limit_a
    panel.axhline(limit, color=GREY, linewidth=1.0, linestyle=DASHED)
    panel.set_ylabel("current (A)")


def _draw_voltage(panel: Axes, trace: RecordedTrace) -> None:
    _draw(panel, trace, (VOLTAGE, "used", BLUE, False))
    panel.plot(trace.columns["time_s"], undistorted_v(trace), color=GREY, linewidth=1.2, linestyle=DASHED)
    panel.set_ylabel("voltage (V)")
