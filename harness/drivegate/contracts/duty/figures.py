"""The figures of a run with duty ratios, in people's units: its signals, its summary and what a campaign observes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.columns import COLUMNS, LINK_COLUMNS, OPTIONAL, VOLTAGE
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.run import DUTY_RATIOS, DutyClosedLoopRun
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.machine import ledger
from drivegate_models.machine.shaft_ledger import shaft_error
from drivegate_models.units import RPM


def signals(run: DutyClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return the columns of a run, one row for each control period; without those that its drive does not have."""
    names = [
        name for name in (*COLUMNS, VOLTAGE) if name not in OPTIONAL or not np.isnan(signal(run, name)[0])
    ]
    if not np.array_equal(run.column("link_highest"), run.column("link")):
        names = [*names, *LINK_COLUMNS]
    return {name: signal(run, name) for name in names}


def signal(run: DutyClosedLoopRun, name: str) -> NDArray[np.float64]:
    """Return one column of a run, shape (n,)."""
    if name == VOLTAGE:
        return run.voltages
    source, factor = COLUMNS.get(name) or LINK_COLUMNS[name]
    return factor * run.column(source)


def observe(record: DutyRecord) -> dict[str, float]:
    """Return what is observed of a run, without what it has no steady state for."""
    run, duration = record.run, record.scenario.duration_s
    observed = {
        "speed_final_rpm": run.column("speed")[-1] * RPM,
        "torque_mean_nm": run.totals[ledger.IMPULSE] / duration,
        "current_peak_a": run.totals[ledger.PEAK],
        "voltage_highest_v": np.max(run.voltages),
        "input_power_mean_w": ledger.source_energy(run.totals) / duration,
        "energy_residual": run.worst_balance,
    }
    return {name: float(value) for name, value in (observed | _of_windows(record.steady)).items()}


def _of_windows(windows: tuple[DutyWindow, ...]) -> dict[str, float]:
    if not windows:
        return {}
    torques = [(window, window.torque_reference) for window in windows]
    speeds = [abs(window.speed - window.speed_reference) for window, torque in torques if torque is None]
    errors = [abs(window.torque - torque) for window, torque in torques if torque is not None]
    last = {"direct_current_mean_a": windows[-1].direct, "quadrature_current_mean_a": windows[-1].quadrature}
    if speeds:
        last["speed_error_worst_rpm"] = max(speeds) * RPM
    if errors:
        last["torque_error_worst_nm"] = max(errors)
    return last


Row = dict[str, Any]


def summary(record: DutyRecord) -> Row:
    """Summarize a run: the whole of it, its steady windows, and the duty ratios that were clipped."""
    return {
        "summary": _summary(record.scenario, record.run),
        "windows": _windows(record),
        "clamped": _clipped_in_words(record.run),
    }


def _summary(scenario: Scenario, run: DutyClosedLoopRun) -> Row:
    columns, duration = signals(run), scenario.duration_s
    return {
        "steps": len(run.trace),
        "speed_final_rpm": float(columns["speed_rpm"][-1]),
        "torque_mean_nm": float(run.totals[ledger.IMPULSE]) / duration,
        "torque_final_nm": float(columns["torque_nm"][-1]),
        "direct_current_final_a": float(columns["direct_current_a"][-1]),
        "quadrature_current_final_a": float(columns["quadrature_current_a"][-1]),
        "current_peak_a": float(run.totals[ledger.PEAK]),
        "voltage_highest_v": float(np.max(columns[VOLTAGE])),
        "input_power_mean_w": float(ledger.source_energy(run.totals)) / duration,
        "energy_residual": run.worst_balance,
        "shaft_residual": shaft_error(run.shaft),
    }


def _windows(record: DutyRecord) -> list[Row]:
    return [
        {
            "start_s": window.start_s,
            "end_s": window.end_s,
            "speed_reference_rpm": window.dwell.speed_rpm,
            "speed_mean_rpm": window.speed * RPM,
            "torque_reference_nm": window.torque_reference,
            "torque_mean_nm": window.torque,
            "direct_current_mean_a": window.direct,
            "quadrature_current_mean_a": window.quadrature,
            "voltage_mean_v": window.voltage,
            "link_voltage_mean_v": window.link,
        }
        for window in record.steady
    ]


def _clipped_in_words(run: DutyClosedLoopRun) -> list[str]:
    """State the extremes of duty ratios that no bridge can make."""
    ratios = np.stack([run.commands[name] for name in DUTY_RATIOS])
    lowest, highest = float(ratios.min()), float(ratios.max())
    words = []
    if highest > 1.0:
        words.append(f"duty ratios clipped to 1: up to {highest:.4g}")
    if lowest < 0.0:
        words.append(f"duty ratios clipped to 0: down to {lowest:.4g}")
    return words
