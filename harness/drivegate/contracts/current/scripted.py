"""Advance angles of a controller on given signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.messages import AnyController
from drivegate.contracts.current.run import refusal_of
from drivegate.contracts.given_steps import GivenSteps
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.layout import CURRENT
from drivegate_models.loop.given_steps import senses_of


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
