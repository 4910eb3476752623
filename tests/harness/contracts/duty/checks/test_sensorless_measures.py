"""What the checks without a position sensor measure, on traces that are made for it."""

from __future__ import annotations

from math import inf, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate.contracts.duty.checks.sensorless.measures import (
    angle_errors,
    back_after_s,
    longest_s,
    mean_and_peak_deg,
    start_of,
    time_below_s,
)

PERIOD = 1e-3


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_start_is_over_when_the_least_speed_is_left_no_more(sense: float) -> None:
    speed = sense * np.array([-1.0, -1.0, 12.0, 8.0, 12.0, 12.0])
    found = start_of(speed, 10.0, sense, 4, PERIOD)
    assert found.reached == pytest.approx(4.0 * PERIOD), "it fell below the least speed once more"
    assert found.backward == pytest.approx(2.0 * 4.0 * PERIOD)


def test_a_shaft_that_never_stays_above_the_least_speed_has_not_started() -> None:
    assert start_of(np.array([12.0, 12.0, 8.0]), 10.0, 1.0, 4, PERIOD).reached == inf
    assert start_of(np.full(3, 12.0), 10.0, -1.0, 4, PERIOD).reached == inf, "it turns the wrong way"


@given(st.integers(1, 12), st.floats(-50.0, 50.0), st.floats(-pi, pi).filter(lambda error: abs(error) < 3.1))
def test_the_error_of_an_angle_is_independent_of_whole_turns(poles: int, angle: float, error: float) -> None:
    estimate = np.array([(angle + error) / poles])
    assert angle_errors(estimate, np.array([angle % (2.0 * pi)]), poles)[0] == pytest.approx(error, abs=1e-9)


def test_errors_near_half_a_turn_have_a_mean_of_half_a_turn() -> None:
    mean, peak = mean_and_peak_deg(np.radians([179.0, -179.0]))
    assert mean == pytest.approx(180.0)
    assert peak == pytest.approx(179.0)
    assert mean_and_peak_deg(np.array([radians(-3.0)] * 5)) == pytest.approx((3.0, 3.0))


def test_the_longest_stretch_is_an_unbroken_one() -> None:
    marked = np.array([1, 1, 0, 1, 1, 1, 0, 1], dtype=bool)
    assert longest_s(marked, PERIOD) == pytest.approx(3.0 * PERIOD)
    assert longest_s(~np.ones(4, dtype=bool), PERIOD) == 0.0
    assert longest_s(np.ones(4, dtype=bool), PERIOD) == pytest.approx(4.0 * PERIOD)


def test_a_speed_is_back_when_it_stays_in_the_band() -> None:
    error = np.array([5.0, 0.0, -5.0, 0.5, 0.0])
    assert back_after_s(error, 1.0, PERIOD) == pytest.approx(3.0 * PERIOD)
    assert back_after_s(np.array([0.0, 5.0]), 1.0, PERIOD) == inf
    assert back_after_s(np.zeros(3), 1.0, PERIOD) == 0.0


def test_the_time_below_the_least_speed_counts_both_senses() -> None:
    assert time_below_s(np.array([20.0, 5.0, -5.0, -20.0]), 10.0, PERIOD) == pytest.approx(2.0 * PERIOD)
