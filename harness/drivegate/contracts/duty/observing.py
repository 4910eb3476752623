"""The figures that a campaign keeps of each run with duty ratios, in people's units."""

from __future__ import annotations

import numpy as np

from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.record import DutyWindow
from drivegate_models.machine import ledger
from drivegate_models.units import RPM


def observe(finished: Record) -> dict[str, float]:
    """Give what is observed of a run, without what it has no steady state for."""
    record = duty_record(finished)
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
