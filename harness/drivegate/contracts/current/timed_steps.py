"""Steps of a controller through given Senses: its advance angles, and the time of a step."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.messages import AnyController
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.run import refusal_of
from drivegate.contracts.given_steps import GivenSteps, step_seconds
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.layout import CURRENT
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.given_steps import senses_of
from drivegate_models.units import RADIANS_PER_RPM

_COLUMNS: Final = ("speed_reference_rpm", "measured_speed_rpm", "current_sum_a", "half_supply_v")


def given_steps(controller: AnyController, nameplate: Nameplate) -> GivenSteps:
    """Reset a controller for steps through given Senses."""
    return GivenSteps(controller, nameplate, CURRENT, refusal_of)


def scripted_angles(
    controller: AnyController, nameplate: Nameplate, signals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Reset a controller, step it through given signals and collect its advance angles."""
    senses = senses_of(signals, nameplate.phases, nameplate.control_period)
    angles: NDArray[np.float64] = given_steps(controller, nameplate).answers(*senses)["advance_angle"]
    return angles


def senses_of_run(run: ClosedLoopRun, nameplate: Nameplate) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """Return what a controller sensed in a run with a trace of every step; the sum is that of the step before."""
    signals = np.stack([run.trace[name] for name in _COLUMNS], axis=1)
    signals[:, :2] *= RADIANS_PER_RPM
    signals[1:, 2] = signals[:-1, 2]
    signals[0, 2] = 0.0
    return senses_of(signals, nameplate.phases, nameplate.control_period)


def current_step_seconds(controller: AnyController, record: CurrentRecord) -> float:
    """Measure the time of a step on what was sensed in a run (s)."""
    nameplate = record.scenario.nameplate()
    return step_seconds(given_steps(controller, nameplate), *senses_of_run(record.run, nameplate))
