"""The figures of a run, in people's units: its signals, its summary and what a campaign observes."""

from __future__ import annotations

from math import degrees
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.current.checks.command_range import LARGEST_ANGLE
from drivegate.contracts.current.columns import EXTREMES, RECORDED
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.run import observed_windows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.machine import ledger
from drivegate_models.machine.shaft_ledger import shaft_error
from drivegate_models.units import RPM


def signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return every column of a run with a trace, without the torque's extremes, which few windows observe."""
    names = (name for name in run.trace.dtype.names or () if name not in EXTREMES)
    return {name: run.trace[name] for name in names}


def recorded_signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return the columns that a result keeps; the supply only where it varies."""
    varying = (name for name in RECORDED if name != "half_supply_v" or np.ptp(run.trace[name]) != 0.0)
    return {name: run.trace[name] for name in varying}


def observe(record: CurrentRecord) -> dict[str, float]:
    """Return the figures of a run, without those of windows that it has not."""
    run, duration = record.run, record.scenario.duration_s
    windows = run.windows
    found = {
        "speed_final_rpm": run.observed.speed_final * RPM,
        "current_sum_mean_a": run.totals[ledger.MAGNITUDE] / duration,
        "current_peak_a": run.totals[ledger.PEAK],
        "torque_mean_nm": run.totals[ledger.IMPULSE] / duration,
        "input_power_mean_w": run.observed.input_energy / duration,
        "shaft_power_mean_w": run.observed.shaft_energy / duration,
        "energy_residual": run.observed.exchange_error,
    }
    if windows:
        last = windows[-1]
        found["speed_error_worst_rpm"] = max(window.speed_error for window in windows) * RPM
        found["torque_ripple_worst_percent"] = max(window.ripple for window in windows) * 100.0
        found["advance_mean_deg"] = degrees(last.angle)
    return {name: float(value) for name, value in found.items()}


_LEAST_IN_DEGREES: Final = 3.0
_MOST_IN_DEGREES: Final = 360.0
_MILLI: Final = 1000.0
_FAR_BEYOND: Final = 50.0


def clamped_in_words(scenario: Scenario, run: ClosedLoopRun) -> list[str]:
    """State the extremes of commands that were clamped before they reached the plant."""
    observed, limit = run.observed, scenario.drive.rating.current_limit_a
    words = []
    if observed.angle_highest > LARGEST_ANGLE:
        angle = observed.angle_highest
        wrong = _LEAST_IN_DEGREES <= angle <= _MOST_IN_DEGREES
        angle_text = f"{angle:.4g} rad: degrees?" if wrong else f"{angle:.4g} rad ({degrees(angle):.4g}°)"
        words.append(f"advance angle clamped to 90°: up to {angle_text}")
    if observed.angle_lowest < 0.0:
        angle = observed.angle_lowest
        words.append(f"advance angle clamped to 0: down to {angle:.4g} rad ({degrees(angle):.4g}°)")
    if observed.reference_highest > limit:
        current = observed.reference_highest
        hint = ": milliamperes?" if _FAR_BEYOND * limit < current <= _MILLI * limit else ""
        words.append(f"current reference clamped to its limit of {limit:g} A: up to {current:.4g} A{hint}")
    if observed.reference_lowest < 0.0:
        words.append(f"current reference clamped to 0: down to {observed.reference_lowest:.4g} A")
    return words


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
        "shaft_residual": shaft_error(run.shaft),
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
            "current_sum_spread_a": row.current_sum_range,
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
