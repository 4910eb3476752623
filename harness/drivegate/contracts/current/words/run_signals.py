"""The recorded signals of a run with a current reference and an advance angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from drivegate.contracts.contract import RecordedTrace


@dataclass(frozen=True)
class RunSignals:
    """A run's signals, and the stretch that a check was judged on."""

    scenario: Scenario
    """What was run."""
    time_s: NDArray[np.float64]
    """Middle of each point's stretch (s), shape (n,)."""
    speed_reference_rpm: NDArray[np.float64]
    speed_rpm: NDArray[np.float64]
    """Speed reference, and true speed (rpm), shape (n,)."""
    current_sum_a: NDArray[np.float64]
    current_reference_a: NDArray[np.float64]
    """Σ|i| and the current reference (A), shape (n,)."""
    advance_deg: NDArray[np.float64]
    """Advance angle (electrical deg), shape (n,)."""
    torque_nm: NDArray[np.float64]
    load_torque_nm: NDArray[np.float64]
    """Electromagnetic torque and the load's (N·m), shape (n,)."""
    judged_s: tuple[float, float]
    """Start and end of the stretch (s)."""

    @property
    def speed_error_rpm(self) -> NDArray[np.float64]:
        """True speed less the reference, shape (n,) (rpm)."""
        return self.speed_rpm - self.speed_reference_rpm

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Which points lie in the judged stretch, shape (n,)."""
        return (self.time_s >= self.judged_s[0]) & (self.time_s <= self.judged_s[1])


def run_signals(trace: RecordedTrace) -> RunSignals:
    """Return the signals of a recorded run."""
    return RunSignals(scenario=trace.scenario, judged_s=trace.judged_s, **trace.columns)
