"""How long a controller's step takes on the Senses of a recorded run."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.messages import AnyController
from drivegate.contracts import given_steps
from drivegate.contracts.current.scripted import given_steps as current_steps
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.given_steps import senses_of
from drivegate_models.units import RADIANS_PER_RPM

_COLUMNS: Final = ("speed_reference_rpm", "measured_speed_rpm", "current_sum_a", "half_supply_v")


def senses_of_run(run: ClosedLoopRun, nameplate: Nameplate) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """Return what a controller sensed in a run with a trace of every step; the sum is that of the step before."""
    signals = np.stack([run.trace[name] for name in _COLUMNS], axis=1)
    signals[:, :2] *= RADIANS_PER_RPM
    signals[1:, 2] = signals[:-1, 2]
    signals[0, 2] = 0.0
    return senses_of(signals, nameplate.phases, nameplate.control_period)


def step_seconds(
    controller: AnyController, nameplate: Nameplate, senses: tuple[NDArray[Any], NDArray[np.float64]]
) -> float:
    """Measure the time of a step (s)."""
    return given_steps.step_seconds(current_steps(controller, nameplate), *senses)
