"""The speed regulator: its gain over the inertia of the shaft, and its integral while the seen speed swings."""

from __future__ import annotations

from math import hypot, pi, radians, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.controllers.duty.test_plausibility import (
    BASE_SPEED,
    INERTIA,
    NAMEPLATE,
    PERIOD,
    RATED_TORQUE,
)

from drivegate_models.contract.duty.records import duty_nameplate_record, duty_sense_record
from drivegate_models.contract.duty.signals import HALL_POSITION
from drivegate_models.controllers.duty.foc import reset_state
from drivegate_models.controllers.duty.position import regulated_speed
from drivegate_models.controllers.duty.speed_regulator import ramped, requested_torque, unwind_speed
from drivegate_models.controllers.duty.state import foc_state

pytestmark = pytest.mark.kernel
FAN = 2.0 * RATED_TORQUE / BASE_SPEED
"""Slope of a fan's rated torque over its speed (N m s/rad)."""


def reset_with(name: str = "foc", /, **nameplate: float) -> Any:
    """Return the state of a controller that has been reset with other values on the nameplate."""
    state: Any = foc_state(name).view(np.recarray)[0]
    reset_state(state, duty_nameplate_record(NAMEPLATE._replace(**nameplate)).view(np.recarray)[0])
    return state


@pytest.mark.parametrize(
    ("inertia", "gain"),
    [
        pytest.param(INERTIA, INERTIA * 0.004 / PERIOD, id="in proportion to the inertia"),
        pytest.param(1e-4, FAN, id="at least the slope of a fan"),
        pytest.param(1e-5, 1e-5 * 0.02 / PERIOD, id="no faster than the currents allow"),
    ],
)
def test_a_light_rotor_has_a_faster_speed_regulator(inertia: float, gain: float) -> None:
    state = reset_with(inertia=inertia)
    assert state.speed_gain == pytest.approx(gain)


@given(
    st.floats(0.01, 0.3),
    st.integers(1, 50),
    st.floats(1e-4, 10.0),
    st.floats(0.01, 3.0),
    st.integers(1, 2),
)
def test_an_error_of_the_position_costs_no_more_than_rated_torque_at_any_speed(
    error: float, pole_pairs: int, inertia: float, speed_share: float, times: int
) -> None:
    """The seen speed is that of an angle which swings by the nameplate's error, once or twice a turn."""
    state = reset_with(pole_pairs=pole_pairs, inertia=inertia, position_error=error)
    speed = speed_share * BASE_SPEED
    around = times * speed
    slope = around * error / pole_pairs
    # What a first-order filter of that rate leaves of a sine.
    rate = state.filter_share / ((1.0 - state.filter_share) * PERIOD)
    left = slope * rate / hypot(rate, around)
    assert state.speed_gain * left <= 1.001 * RATED_TORQUE


@pytest.mark.parametrize("share", [0.3, 1.0, 10.0])
def test_an_error_of_hall_switches_leaves_torque_for_the_load(share: float) -> None:
    """A swing that the greatest torque cuts on one side would take the mean speed off its reference."""
    error, pairs = radians(2.5), 15
    limit = share * NAMEPLATE.current_limit
    hall = {"position": HALL_POSITION, "position_error": error, "current_limit": limit}
    state = reset_with(pole_pairs=pairs, inertia=10.0, **hall)
    # At each edge, the observer corrects the speed by twice its rate.
    swing = state.speed_gain * 2.0 * state.observer_rate * error / pairs
    assert swing == pytest.approx(min(RATED_TORQUE, 0.5 * state.greatest_torque))


def test_an_exact_position_slows_the_speed_regulator_of_no_machine() -> None:
    state = reset_with(pole_pairs=1, inertia=2.0)
    assert state.speed_gain == pytest.approx(2.0 * 0.004 / PERIOD)
    assert state.filter_share == 1.0


def test_the_filter_of_the_speed_is_at_least_six_times_as_fast_as_its_regulator() -> None:
    for inertia in (1e-4, 1e-2, 1.0, 100.0):
        state = reset_with(pole_pairs=1, inertia=inertia, position_error=0.2)
        rate = state.filter_share / ((1.0 - state.filter_share) * PERIOD)
        assert rate >= 5.99 * state.speed_gain / inertia


def test_the_seen_speed_is_filtered_from_its_first_value() -> None:
    state = reset_with(pole_pairs=1, inertia=1.0, position_error=0.2)
    sense: Any = duty_sense_record(np.zeros(3)).view(np.recarray)[0]
    assert regulated_speed(state, sense, 100.0) == 100.0
    assert regulated_speed(state, sense, 200.0) == pytest.approx(100.0 + 100.0 * state.filter_share)
    assert 0.0 < state.filter_share < 0.1


def test_a_seen_speed_that_swings_does_not_lower_the_mean_speed() -> None:
    """The torque follows its request at a limited rate, which must not stop the integral in half of each swing."""
    state = reset_with()
    amplitude, swings, steps = 0.03 * BASE_SPEED, 20, 50
    state.speed_integral = state.torque = RATED_TORQUE
    for step in range(swings * steps):
        speed = BASE_SPEED + amplitude * sin(2.0 * pi * step / steps)
        requested = requested_torque(state, BASE_SPEED, speed)
        unwind_speed(state, BASE_SPEED, speed, requested, ramped(state, requested))
    one_half = state.speed_integral_step * amplitude * steps / pi
    assert abs(state.speed_integral - RATED_TORQUE) < 1.1 * one_half, (
        "the integral drifts from one swing to the next"
    )
