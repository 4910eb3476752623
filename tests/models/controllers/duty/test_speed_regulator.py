"""The speed regulator: its gain over the inertia of the shaft, and its integral while the seen speed swings."""

from __future__ import annotations

from math import pi, sin
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
from drivegate_models.controllers.duty.foc import _ramped, _requested_torque, _unwind_speed, reset_state
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


def test_a_sensor_of_one_pole_pair_has_a_slower_speed_regulator() -> None:
    """Errors of 2 electrical degrees twice a turn swing the seen speed by 7 %, and the torque by half of the rated."""
    state: Any = foc_state("foc").view(np.recarray)[0]
    nameplate = NAMEPLATE._replace(pole_pairs=1, inertia=0.02)
    reset_state(state, duty_nameplate_record(nameplate).view(np.recarray)[0])
    assert state.speed_gain * 0.07 * BASE_SPEED == pytest.approx(0.5 * RATED_TORQUE)


def test_a_seen_speed_that_swings_does_not_lower_the_mean_speed() -> None:
    """The torque follows its request at a limited rate, which must not stop the integral in half of each swing."""
    state: Any = foc_state("foc").view(np.recarray)[0]
    reset_state(state, duty_nameplate_record(NAMEPLATE).view(np.recarray)[0])
    amplitude, swings, steps = 0.03 * BASE_SPEED, 20, 50
    state.speed_integral = state.torque = RATED_TORQUE
    for step in range(swings * steps):
        speed = BASE_SPEED + amplitude * sin(2.0 * pi * step / steps)
        requested = _requested_torque(state, BASE_SPEED, speed)
        _unwind_speed(state, BASE_SPEED, speed, requested, _ramped(state, requested))
    one_half = state.speed_integral_step * amplitude * steps / pi
    assert abs(state.speed_integral - RATED_TORQUE) < 1.1 * one_half, (
        "the integral drifts from one swing to the next"
    )
