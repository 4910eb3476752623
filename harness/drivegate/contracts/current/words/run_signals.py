"""The recorded signals of a run with a current reference and an advance angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from drivegate.contracts.trace import RecordedTrace


@dataclass(frozen=True)
class RunSignals:
    """A run's signals, and the stretch that a check was judged on.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    time_s : ndarray, shape (n,)
        Middle of each point's stretch (s).
    speed_reference_rpm, speed_rpm : ndarray, shape (n,)
        Speed reference, and true speed (rpm).
    current_sum_a, current_reference_a : ndarray, shape (n,)
        Σ|i| and the current reference (A).
    advance_deg : ndarray, shape (n,)
        Advance angle (electrical deg).
    torque_nm, load_torque_nm : ndarray, shape (n,)
        Electromagnetic torque and the load's (N·m).
    judged_s : tuple of float
        Start and end of the stretch (s).
    """

    scenario: Scenario
    time_s: NDArray[np.float64]
    speed_reference_rpm: NDArray[np.float64]
    speed_rpm: NDArray[np.float64]
    current_sum_a: NDArray[np.float64]
    current_reference_a: NDArray[np.float64]
    advance_deg: NDArray[np.float64]
    torque_nm: NDArray[np.float64]
    load_torque_nm: NDArray[np.float64]
    judged_s: tuple[float, float]

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
