"""The gain of the speed regulator over the inertia of the shaft."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.models.controllers.duty.test_plausibility import (
    BASE_SPEED,
    INERTIA,
    NAMEPLATE,
    PERIOD,
    RATED_TORQUE,
)

from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.controllers.duty.foc import reset_state
from drivegate_models.controllers.duty.state import foc_state

pytestmark = pytest.mark.kernel
FAN = 2.0 * RATED_TORQUE / BASE_SPEED
"""Slope of a fan's rated torque over its speed (N m s/rad)."""


@pytest.mark.parametrize(
    ("inertia", "gain"),
    [
        pytest.param(INERTIA, INERTIA * 0.004 / PERIOD, id="in proportion to the inertia"),
        pytest.param(1e-4, FAN, id="at least the slope of a fan"),
        pytest.param(1e-5, 1e-5 * 0.02 / PERIOD, id="no faster than the currents allow"),
    ],
)
def test_a_light_rotor_has_a_faster_speed_regulator(inertia: float, gain: float) -> None:
    state: Any = foc_state("foc").view(np.recarray)[0]
    nameplate = NAMEPLATE._replace(inertia=inertia)
    reset_state(state, duty_nameplate_record(nameplate).view(np.recarray)[0])
    assert state.speed_gain == pytest.approx(gain)
