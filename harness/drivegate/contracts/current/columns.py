"""Names and units of what is recorded of a run, summarized and observed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Final

from drivegate.contracts.contract import Contract
from drivegate.contracts.drawings import Line, Panel

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
EXTREMES: Final = ("torque_lowest_nm", "torque_highest_nm")
"""Columns of the trace that have numbers only where a window observes the ripple of the torque."""


class CurrentColumns(Contract):
    """What the contract declares of its signals, apart from all that imports compiled code."""

    sensed: ClassVar[Mapping[str, str]] = {
        "speed_reference": "rad/s",
        "speed": "rad/s",
        "current_magnitude_sum": "A",
        "half_supply_voltage": "V",
        "phase_currents": "A",
    }
    moved_by: ClassVar[Mapping[str, str]] = {
        "time": "duration_s, clock_start_s",
        "speed_reference": "speed_rpm",
        "speed": "speed_rpm, initial_speed_rpm, load, sensors",
        "current_magnitude_sum": "load, current_errors",
        "half_supply_voltage": "supply_v, imbalance",
        "phase_currents": "load, current_errors, dropouts",
    }
    outputs: ClassVar[Mapping[str, tuple[str, str]]] = {
        "current_reference": ("current reference", "A"),
        "advance_angle": ("advance angle", "rad"),
        "input_power": ("input power", "W"),
    }
    plotted: ClassVar[Mapping[str, tuple[str, float]]] = {
        "current_reference": ("A", 1.0),
        "advance_angle": ("el. deg", 180.0 / math.pi),
    }
    panels = (
        Panel(
            "speed (rpm)",
            (
                Line("speed_reference_rpm", "reference", True),
                Line("speed_rpm", "speed"),
                Line("sensed_speed_rpm", "sensed", is_sensed=True),
            ),
        ),
        Panel("angle (el. deg)", (Line("advance_deg", "advance angle"),)),
        Panel(
            "current (A)",
            (
                Line("current_sum_a", "Σ|i|"),
                Line("sensed_current_sum_a", "sensed Σ|i|", is_sensed=True),
                Line("current_reference_a", "current reference", True),
            ),
        ),
        Panel("torque (N·m)", (Line("load_torque_nm", "load", True), Line("torque_nm", "torque"))),
        Panel(
            "half supply (V)",
            (Line("half_supply_v", "true"), Line("sensed_half_supply_v", "sensed", is_sensed=True)),
        ),
    )
    recorded_names = tuple(name for name in RECORDED if name != "half_supply_v")
    signal_names = (*RECORDED, "input_power_w", "measured_speed_rpm")
    further_names = ("half_supply_v", "sensed_speed_rpm", "sensed_current_sum_a", "sensed_half_supply_v")
    summary_rows = (
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
    window_columns = (
        ("speed_error_worst_rpm", "worst error (rpm)"),
        ("current_sum_mean_a", "Σ|i| (A)"),
        ("torque_mean_nm", "torque (N·m)"),
        ("input_power_mean_w", "input power (W)"),
        ("advance_mean_deg", "angle (°)"),
    )
    observations = (
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
