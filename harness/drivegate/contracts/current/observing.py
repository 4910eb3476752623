"""The figures that a campaign keeps of each run, in people's units."""

from __future__ import annotations

from math import degrees

from drivegate.contracts.current.record import CurrentRecord
from drivegate_models.machine import ledger
from drivegate_models.units import RPM


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
