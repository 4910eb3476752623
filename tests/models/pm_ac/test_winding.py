"""The thermal node of the windings: an independent solution, and nothing at all without thermal data."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from drivegate_models.pm_ac.winding import (
    SENSED,
    TRUE,
    copied_winding,
    heat_winding,
    make_winding,
    no_winding,
    resistance_factor,
    shown_temperature,
)

PERIOD = 1e-4


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    capacity=st.floats(0.05, 2000.0),
    resistance=st.floats(0.02, 50.0),
    lag=st.sampled_from((0.0, PERIOD, 1.0)) | st.floats(PERIOD, 100.0),
    losses=st.lists(st.floats(0.0, 2000.0), min_size=1, max_size=30),
    initial=st.floats(0.0, 150.0),
)
def test_node_and_sensor_are_those_of_the_matrix_exponential(
    capacity: float, resistance: float, lag: float, losses: list[float], initial: float
) -> None:
    capacity = max(capacity, PERIOD / resistance)
    winding = make_winding(
        heat_capacity=capacity,
        thermal_resistance=resistance,
        ambient=25.0,
        coefficient=0.004,
        control_period=PERIOD,
        initial=initial,
        lag=lag,
    )
    # The mean loss is a third state that does not change.
    system = np.zeros((3, 3))
    system[0, 0], system[0, 2] = -1.0 / (capacity * resistance), 1.0 / capacity
    if lag:
        system[1, 0], system[1, 1] = 1.0 / lag, -1.0 / lag
    step = expm(system * PERIOD)
    state = np.array([initial - 25.0, initial - 25.0, 0.0])
    for loss in losses:
        heat_winding(winding, loss)
        state[2] = loss
        state = step @ state
        sensed = state[1] if lag else state[0]
        scale = 1e-11 * (200.0 + loss * resistance)
        assert winding.state[TRUE] == pytest.approx(25.0 + state[0], abs=scale)
        assert winding.state[SENSED] == pytest.approx(25.0 + sensed, abs=scale)
    assert resistance_factor(winding) == pytest.approx(1.0 + 0.004 * state[0], abs=1e-9)


@pytest.mark.kernel
def test_without_thermal_data_nothing_changes_and_nothing_is_sensed() -> None:
    winding = no_winding()
    heat_winding(winding, 100.0)
    assert resistance_factor(winding) == 1.0
    assert np.isnan(shown_temperature(winding))
    assert np.isnan(winding.state).all()


@pytest.mark.kernel
def test_a_node_without_a_sensor_gets_hot_unseen_and_a_copy_has_its_own_state() -> None:
    winding = make_winding(
        heat_capacity=2.0,
        thermal_resistance=1.5,
        ambient=20.0,
        coefficient=0.004,
        control_period=PERIOD,
        initial=20.0,
        lag=None,
    )
    copy = copied_winding(winding)
    heat_winding(winding, 1e4)
    assert np.isnan(shown_temperature(winding))
    assert winding.state[TRUE] == pytest.approx(20.5, rel=1e-4)
    assert copy.state[TRUE] == 20.0
