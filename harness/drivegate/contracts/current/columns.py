"""Names and units of what is recorded of a run, summarized and observed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from drivegate.contracts.drawings import Line, Panel

SENSED: Final[Mapping[str, str]] = {
    "speed_reference": "rad/s",
    "speed": "rad/s",
    "current_magnitude_sum": "A",
    "half_supply_voltage": "V",
    "phase_currents": "A",
}
"""What is sensed, with its unit."""
OUTPUTS: Final[Mapping[str, tuple[str, str]]] = {
    "current_reference": ("current reference", "A"),
    "advance_angle": ("advance angle", "rad"),
    "input_power": ("input power", "W"),
}
"""Fields of a command, each with its name and unit."""
PLOTTED: Final[Mapping[str, tuple[str, float]]] = {
    "current_reference": ("A", 1.0),
    "advance_angle": ("el. deg", 180.0 / math.pi),
}
"""Fields of a command that figures show, each with the unit there and a factor for it."""
RECORDED: Final = (
    "time_s",
    "speed_reference_rpm",
    "speed_rpm",
    "current_sum_a",
    "current_reference_a",
    "advance_deg",
    "torque_nm",
    "load_torque_nm",
    "half_supply_v",
)
"""Columns of the trace that a result keeps."""
PANELS: Final = (
    Panel("speed (rpm)", (Line("speed_reference_rpm", "reference", True), Line("speed_rpm", "speed"))),
    Panel("angle (el. deg)", (Line("advance_deg", "advance angle"),)),
    Panel(
        "current (A)", (Line("current_sum_a", "Σ|i|"), Line("current_reference_a", "current reference", True))
    ),
    Panel("torque (N·m)", (Line("load_torque_nm", "load", True), Line("torque_nm", "torque"))),
)
"""How figures show these columns."""
RECORDED_NAMES: Final = tuple(name for name in RECORDED if name != "half_supply_v")
"""Those without which a run cannot be described: the supply is recorded only where it varies."""
SUMMARY_ROWS: Final = (
    ("speed_final_rpm", "speed at the end", "rpm"),
    ("speed_error_worst_rpm", "speed error, worst", "rpm"),
    ("current_sum_mean_a", "Σ|i|, mean", "A"),
    ("current_peak_a", "phase current, peak", "A"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("input_power_mean_w", "input power, mean", "W"),
    ("shaft_power_mean_w", "shaft power, mean", "W"),
    ("advance_mean_deg", "advance angle, mean", "°"),
    ("advance_final_deg", "advance angle at the end", "°"),
    ("current_reference_final_a", "current reference at the end", "A"),
    ("kinetic_residual_j", "kinetic residual of the held speed", "J"),
)
"""Keys of a summary to print, each with its name and unit."""
WINDOW_COLUMNS: Final = (
    ("speed_error_worst_rpm", "worst error (rpm)"),
    ("current_sum_mean_a", "Σ|i| (A)"),
    ("torque_mean_nm", "torque (N·m)"),
    ("input_power_mean_w", "input power (W)"),
    ("advance_mean_deg", "angle (°)"),
)
"""Keys of a steady window to print, each with its heading."""
OBSERVATIONS: Final = (
    "speed_final_rpm",
    "speed_error_worst_rpm",
    "current_sum_mean_a",
    "current_peak_a",
    "torque_mean_nm",
    "torque_ripple_worst_percent",
    "input_power_mean_w",
    "shaft_power_mean_w",
    "advance_mean_deg",
    "energy_residual",
)
"""Names of the figures that a campaign keeps of each run."""
