"""Names and units of what is recorded of a run, summarized and observed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Final

from drivegate.contracts.contract import Contract
from drivegate.contracts.drawings import Line, Panel
from drivegate_models.units import RADIANS_PER_RPM

COLUMNS: Final[Mapping[str, tuple[str, float]]] = {
    "time_s": ("time", 1.0),
    "speed_reference_rpm": ("speed_reference", 1.0 / RADIANS_PER_RPM),
    "speed_rpm": ("speed", 1.0 / RADIANS_PER_RPM),
    "torque_reference_nm": ("torque_reference", 1.0),
    "torque_nm": ("torque", 1.0),
    "load_torque_nm": ("load", 1.0),
    "direct_current_a": ("direct", 1.0),
    "quadrature_current_a": ("quadrature", 1.0),
    "peak_current_a": ("peak_current", 1.0),
    "input_power_w": ("input_power", 1.0),
    "link_voltage_v": ("link", 1.0),
    "winding_temperature_c": ("winding_temperature", 1.0),
}
"""Columns that a result keeps, each with its source in the trace and a factor on it."""
LINK_COLUMNS: Final[Mapping[str, tuple[str, float]]] = {
    "link_highest_v": ("link_highest", 1.0),
    "source_current_a": ("source_current", 1.0),
    "chopper_power_w": ("chopper_power", 1.0),
}
"""More of them where the link is not ideal."""
OPTIONAL: Final = frozenset({"winding_temperature_c"})
"""Columns that are NaN throughout for a drive without the quantity."""
VOLTAGE: Final = "voltage_v"
"""One more column: the peak phase voltage that the duty ratios request."""
_ALWAYS: Final = (*(name for name in COLUMNS if name not in OPTIONAL), VOLTAGE)


class DutyColumns(Contract):
    """What the contract declares of its signals, apart from all that imports compiled code."""

    sensed: ClassVar[Mapping[str, str]] = {
        "reference": "rad/s or N·m",
        "speed": "rad/s",
        "angle": "rad",
        "supply_voltage": "V",
        "supply_current": "A",
        "source_current": "A",
        "phase_currents": "A",
        "phase_voltages": "V",
        "mean_voltages": "V",
        "winding_temperature": "°C",
    }
    moved_by: ClassVar[Mapping[str, str]] = {
        "time": "duration_s, clock_start_s",
        "reference": "speed_rpm, or the reference of load",
        "speed": "speed_rpm, initial_speed_rpm, load",
        "angle": "initial_angle_deg, turns_before, sensors",
        "phase_currents": "load, current_errors, dropouts, failure",
        "supply_voltage": "link_voltage_v, failure",
        "supply_current": "load, link_voltage_v",
        "phase_voltages": "initial_speed_rpm while the bridge is off",
        "mean_voltages": "speed_rpm, link_voltage_v, and sensing of the drive",
        "source_current": "the link of the drive, load",
        "winding_temperature": "winding_temperature_c, and thermal of the drive",
        "trip": "link_voltage_v beyond the limits of the link of the drive",
        "hall": "sensors with Hall switches, dropouts",
        "encoder_count": "sensors with an encoder, glitches",
        "enable": "restarts_s, and reads_enable = true in the manifest",
    }
    outputs: ClassVar[Mapping[str, tuple[str, str]]] = {
        "first_duty": ("first duty ratio", ""),
        "second_duty": ("second duty ratio", ""),
        "third_duty": ("third duty ratio", ""),
        "first_leg": ("first leg", ""),
        "second_leg": ("second leg", ""),
        "third_leg": ("third leg", ""),
        "next_period": ("next control period", "s"),
        "torque": ("torque", "N·m"),
        "angle": ("angle", "rad"),
        "speed": ("speed", "rad/s"),
        "input_power": ("input power", "W"),
        "fault": ("fault", ""),
        "brake_duty": ("duty ratio of the chopper", ""),
    }
    plotted: ClassVar[Mapping[str, tuple[str, float]]] = {
        "first_duty": ("1", 1.0),
        "second_duty": ("1", 1.0),
        "third_duty": ("1", 1.0),
    }
    panels = (
        Panel("torque (N·m)", (Line("torque_reference_nm", "reference", True), Line("torque_nm", "torque"))),
        Panel(
            "speed (rpm)",
            (
                Line("speed_reference_rpm", "reference", True),
                Line("speed_rpm", "speed"),
                Line("sensed_speed_rpm", "sensed", is_sensed=True),
            ),
        ),
        Panel(
            "current (A)",
            (
                Line("direct_current_a", "d"),
                Line("quadrature_current_a", "q"),
                Line("peak_current_a", "peak"),
                Line("sensed_direct_current_a", "sensed d", is_sensed=True),
                Line("sensed_quadrature_current_a", "sensed q", is_sensed=True),
            ),
        ),
        Panel(
            "voltage (V)",
            (
                Line("link_voltage_v", "link", True),
                Line(VOLTAGE, "used"),
                Line("sensed_link_voltage_v", "sensed link", is_sensed=True),
            ),
        ),
        Panel("source current (A)", (Line("source_current_a", "source"),)),
        Panel("chopper power (W)", (Line("chopper_power_w", "chopper"),)),
        Panel("sensed angle (el. deg)", (Line("sensed_angle_error_deg", "error", is_sensed=True),)),
    )
    panels_of_speed = (
        Panel("torque (N·m)", (Line("load_torque_nm", "load", True), Line("torque_nm", "torque"))),
        *panels[1:],
    )
    """Panels of a run without a torque reference."""
    signal_names = (*COLUMNS, VOLTAGE)
    recorded_names = _ALWAYS
    further_names = (
        *OPTIONAL,
        *LINK_COLUMNS,
        "sensed_direct_current_a",
        "sensed_quadrature_current_a",
        "sensed_speed_rpm",
        "sensed_link_voltage_v",
        "sensed_angle_error_deg",
    )
    summary_rows = (
        ("speed_final_rpm", "speed at the end", "rpm"),
        ("torque_mean_nm", "torque, mean", "N·m"),
        ("torque_final_nm", "torque at the end", "N·m"),
        ("direct_current_final_a", "d current at the end", "A"),
        ("quadrature_current_final_a", "q current at the end", "A"),
        ("current_peak_a", "phase current, peak", "A"),
        ("voltage_highest_v", "phase voltage, highest", "V"),
        ("input_power_mean_w", "input power, mean", "W"),
    )
    window_columns = (
        ("speed_mean_rpm", "speed (rpm)"),
        ("torque_mean_nm", "torque (N·m)"),
        ("direct_current_mean_a", "d (A)"),
        ("quadrature_current_mean_a", "q (A)"),
        ("voltage_mean_v", "voltage (V)"),
    )
    observations = (
        "speed_final_rpm",
        "speed_error_worst_rpm",
        "torque_mean_nm",
        "torque_error_worst_nm",
        "direct_current_mean_a",
        "quadrature_current_mean_a",
        "current_peak_a",
        "voltage_highest_v",
        "input_power_mean_w",
        "energy_residual",
    )
