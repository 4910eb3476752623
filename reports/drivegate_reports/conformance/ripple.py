"""The torque that a check of the ideal regulator's ripple looks at, computed again from the recorded run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from drivegate.contracts.current.words.run_signals import RunSignals
from drivegate_cases.drive.limits import limits_of
from drivegate_models.errors import InputError
from drivegate_reports.paper.figures.instantaneous_torque import TorqueCycle, cycle_at

_OF_STEADY_STATES: Final = ("RIP-1", "RIP-2")
_SHORT: Final = 0.999


@dataclass(frozen=True)
class Ripple:
    """Torque over one electrical period at the operating point that a check judged."""

    cycle: TorqueCycle
    """The torque in the steady state at the angle and the mean torque of the judged stretch."""
    limit: float
    """Largest peak-to-peak ripple over the mean (1)."""
    demanded_nm: float
    """Mean torque of the judged stretch (N·m)."""

    @property
    def is_short(self) -> bool:
        """Whether the torque is out of reach, so that the cycle is that at the current limit."""
        return self.cycle.mean_nm < _SHORT * self.demanded_nm


def ripple_of(check: str, signals: RunSignals) -> Ripple | None:
    """Compute the torque at the judged operating point; None for other checks, and where there was no torque."""
    if check not in _OF_STEADY_STATES or not signals.judged.any():
        return None
    speed, angle, torque = (
        float(np.mean(values[signals.judged]))
        for values in (signals.speed_reference_rpm, signals.advance_deg, signals.torque_nm)
    )
    if speed <= 0.0 or torque <= 0.0:
        return None
    ideal = signals.scenario.drive.plant(signals.scenario.scales)._replace(hysteresis_band=0.0)
    try:
        cycle = cycle_at(ideal, speed, min(max(angle, 0.0), 90.0), torque)
    except InputError:
        return None
    limit = limits_of(signals.scenario.drive).ripple
    return Ripple(cycle, limit, torque) if cycle.mean_nm > 0.0 and np.isfinite(limit) else None
