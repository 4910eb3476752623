"""The summary of a run, in people's units."""

from __future__ import annotations

from math import degrees
from typing import Any

from drivegate.contracts.current.clamping import clamped_in_words
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.windows import observed_windows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.machine import ledger
from drivegate_models.units import RPM


def summary(record: CurrentRecord) -> dict[str, Any]:
    """Summarize a run: the whole of it, its steady windows, and the commands that were clamped."""
    return {
        "summary": _summary(record.scenario, record.run),
        "windows": _windows(record.scenario, record.run),
        "clamped": clamped_in_words(record.scenario, record.run),
    }


def _summary(scenario: Scenario, run: ClosedLoopRun) -> dict[str, Any]:
    duration, columns = scenario.duration_s, run.trace
    errors = abs(columns["speed_rpm"] - columns["speed_reference_rpm"])
    worst = int(errors.argmax())
    return {
        "steps": run.steps,
        "speed_final_rpm": run.observed.speed_final * RPM,
        "speed_error_worst_rpm": float(errors[worst]),
        "speed_error_worst_at_s": float(columns["time_s"][worst]),
        "current_sum_mean_a": float(run.totals[ledger.MAGNITUDE]) / duration,
        "current_peak_a": float(run.totals[ledger.PEAK]),
        "torque_mean_nm": float(run.totals[ledger.IMPULSE]) / duration,
        "input_power_mean_w": run.observed.input_energy / duration,
        "shaft_power_mean_w": run.observed.shaft_energy / duration,
        "advance_mean_deg": float(columns["advance_deg"].mean()),
        "advance_final_deg": float(columns["advance_deg"][-1]),
        "current_reference_final_a": float(columns["current_reference_a"][-1]),
        "energy_residual": run.observed.exchange_error,
        "kinetic_residual_j": run.observed.kinetic_residual,
    }


def _windows(scenario: Scenario, run: ClosedLoopRun) -> list[dict[str, float]]:
    return [
        {
            "start_s": start,
            "end_s": end,
            "speed_mean_rpm": row.speed * RPM,
            "speed_error_worst_rpm": row.speed_error * RPM,
            "current_sum_mean_a": row.current_sum,
            "current_sum_spread_a": float(row.mean_highest - row.mean_lowest),
            "torque_mean_nm": row.torque,
            "input_power_mean_w": row.input_power,
            "exchanged_power_mean_w": row.exchanged_power,
            "advance_mean_deg": degrees(row.angle),
            "advance_spread_deg": degrees(row.angle_highest - row.angle_lowest),
            "current_reference_mean_a": row.reference,
            "current_peak_a": row.peak,
        }
        for (start, end), row in zip(observed_windows(scenario), run.windows, strict=True)
    ]
