"""How long a controller's step takes, measured from outside of the process that runs it."""

from __future__ import annotations

from statistics import median
from time import perf_counter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.timing import TIMED_STEPS
from drivegate.containment.messages import AnyController
from drivegate.contracts.current.scripted import GivenSteps
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.given_steps import senses_of
from drivegate_models.units import RADIANS_PER_RPM

_ROUNDS: Final = 5
_COLUMNS: Final = ("speed_reference_rpm", "measured_speed_rpm", "current_sum_a", "half_supply_v")


def senses_of_run(run: ClosedLoopRun, nameplate: Nameplate) -> NDArray[np.float64]:
    """Give what a controller sensed in a run with a trace of every step; the sum given is that of the step before."""
    signals = np.stack([run.trace[name] for name in _COLUMNS], axis=1)
    signals[:, :2] *= RADIANS_PER_RPM
    signals[1:, 2] = signals[:-1, 2]
    signals[0, 2] = 0.0
    return senses_of(signals, nameplate.phases, nameplate.control_period)


def step_seconds(controller: AnyController, nameplate: Nameplate, senses: NDArray[np.float64]) -> float:
    """Measure the time of a step (s).

    What it takes to hand Senses over and commands back is left out: the first step, taken alone, has it too.
    """
    senses = senses[:TIMED_STEPS]
    times = []
    for _ in range(_ROUNDS):
        steps = GivenSteps(controller, nameplate)
        alone = _seconds(steps, senses[:1])
        times.append((_seconds(steps, senses[1:]) - alone) / max(len(senses) - 1, 1))
    # What the machine does besides, or compiles at first, is in few rounds.
    return max(median(times), 0.0)


def _seconds(steps: GivenSteps, senses: NDArray[np.float64]) -> float:
    started = perf_counter()
    steps.answers(senses)
    return perf_counter() - started
