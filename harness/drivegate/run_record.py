"""What the checks see of one finished run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivegate.declaration import Declaration
from drivegate.scenario_run import RADIANS_PER_RPM, observed_windows
from drivegate_cases.profile import Dwell, dwells
from drivegate_cases.scenario import Scenario
from drivegate_models.closed_loop import ClosedLoopRun
from drivegate_models.drive import Drive


@dataclass(frozen=True)
class Window:
    """A stretch in which convergence is judged.

    Attributes
    ----------
    dwell : Dwell
        The constant conditions it belongs to.
    values : ndarray, shape (observation.WINDOW_ENTRIES,)
        What was observed.
    """

    dwell: Dwell
    values: NDArray[np.float64]

    @property
    def speed(self) -> float:
        """Speed reference (rad/s)."""
        return self.dwell.speed_rpm * RADIANS_PER_RPM


@dataclass(frozen=True)
class RunRecord:
    """A finished run with what belongs to it.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    run : ClosedLoopRun
        What was observed.
    declaration : Declaration
        What the candidate declares of itself.
    repeated_digests : tuple of int
        Digests of further runs of the same scenario; empty where it ran once.
    """

    scenario: Scenario
    run: ClosedLoopRun
    declaration: Declaration
    repeated_digests: tuple[int, ...] = ()

    @cached_property
    def drive(self) -> Drive:
        """The plant that the run was made on."""
        return self.scenario.motor.drive(self.scenario.scales)

    def windows(self) -> Iterator[Window]:
        """Go through the stretches in which convergence is judged.

        Yields
        ------
        Window
            Conditions and observations.
        """
        observed = observed_windows(self.scenario)
        by_end = {dwell.end: dwell for dwell in dwells(self.scenario)}
        for (_, end), values in zip(observed, self.run.windows, strict=True):
            yield Window(by_end[end], values)


def rated_torque(scenario: Scenario, speed: float) -> float:
    """Give the torque of the motor's rated power at a speed.

    Parameters
    ----------
    scenario : Scenario
        The scenario, whose motor has the rated power.
    speed : float
        Shaft speed (rad/s), above 0.

    Returns
    -------
    float
        Torque (N m).
    """
    return scenario.motor.rated_power_w / speed
