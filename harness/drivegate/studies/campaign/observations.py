"""What is observed of every run of a campaign, by the contract of its controller."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from types import MappingProxyType
from typing import Final

from drivegate.contracts.current.record import RunRecord
from drivegate.studies.campaign.duty.observations import DUTY_OBSERVATIONS, duty_observed
from drivegate_models.machine import ledger
from drivegate_models.units import RPM

OBSERVATIONS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "current": (
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
        ),
        "duty": DUTY_OBSERVATIONS,
    }
)
"""What is observed of a run with a controller of each contract, in people's units."""


def observed(record: RunRecord) -> dict[str, float]:
    """Give what is observed of a run, by the names of its contract in `OBSERVATIONS`."""
    if record.scenario.drive.contract == "duty":
        return duty_observed(record)
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
