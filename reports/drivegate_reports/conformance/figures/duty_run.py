"""The signals of one run of a controller of duty ratios: speed, torque, currents and voltage over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.contracts.duty.columns import VOLTAGE
from drivegate.contracts.duty.words import DutySignals
from drivegate_reports.conformance.figures.run_panels import (
    LABELS_AT,
    finish_run_panels,
    new_run_panels,
)
from drivegate_reports.page.style import BLUE, DASHED, GREEN, GREY, VERMILION, label_ends

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CAPTION: Final = (
    "Means over equal stretches of the run. Dashed: references, the current limit, and the undistorted voltage of the "
    "link."
)


def alternative(signals: DutySignals) -> str:
    last = {name: float(values[-1]) for name, values in signals.columns.items()}
    return (
        f"Four panels over {signals.scenario.duration_s:g} s. The speed ends at {last['speed_rpm']:.5g} rpm, "
        f"the torque at {last['torque_nm']:.4g} N·m. The currents of the rotor's frame end at "
        f"{last['direct_current_a']:.4g} A and {last['quadrature_current_a']:.4g} A, the voltage at "
        f"{last[VOLTAGE]:.4g} V of {signals.undistorted_v[-1]:.4g} V."
    )


def draw(signals: DutySignals) -> Figure:
    figure, panels = new_run_panels()
    _draw_speed(panels[0], signals)
    _draw_torque(panels[1], signals)
    _draw_currents(panels[2], signals)
    _draw_voltage(panels[3], signals)
    finish_run_panels(panels, signals.scenario.duration_s)
    return figure


def _draw(panel: Axes, signals: DutySignals, *lines: tuple[str, str, str, bool]) -> None:
    """Draw columns, each with a label at its end: column, label, colour, and whether it is dashed."""
    time = signals.columns["time_s"]
    for column, _, colour, dashed in lines:
        style = DASHED if dashed else "-"
        panel.plot(time, signals.columns[column], color=colour, linestyle=style, linewidth=1.3)
    ends = [(label, float(signals.columns[column][-1]), colour) for column, label, colour, _ in lines]
    label_ends(panel, LABELS_AT * signals.scenario.duration_s, *ends)


def _draw_speed(panel: Axes, signals: DutySignals) -> None:
    name = "held" if signals.gives_torque else "reference"
    _draw(panel, signals, ("speed_reference_rpm", name, GREY, True), ("speed_rpm", "speed", BLUE, False))
    panel.set_ylabel("speed (rpm)")


def _draw_torque(panel: Axes, signals: DutySignals) -> None:
    wanted = ("torque_reference_nm", "reference") if signals.gives_torque else ("load_torque_nm", "load")
    _draw(panel, signals, (*wanted, GREY, True), ("torque_nm", "motor", BLUE, False))
    panel.set_ylabel("torque (N·m)")


def _draw_currents(panel: Axes, signals: DutySignals) -> None:
    lines = (
        ("direct_current_a", "d", VERMILION),
        ("quadrature_current_a", "q", BLUE),
        ("peak_current_a", "peak", GREEN),
    )
    _draw(panel, signals, *((*line, False) for line in lines))
    limit = signals.scenario.drive.rating.current_limit_a
    panel.axhline(limit, color=GREY, linewidth=1.0, linestyle=DASHED)
    panel.set_ylabel("current (A)")


def _draw_voltage(panel: Axes, signals: DutySignals) -> None:
    _draw(panel, signals, (VOLTAGE, "used", BLUE, False))
    panel.plot(signals.columns["time_s"], signals.undistorted_v, color=GREY, linewidth=1.2, linestyle=DASHED)
    panel.set_ylabel("voltage (V)")
