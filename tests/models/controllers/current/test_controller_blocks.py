"""The blocks of the built-in controllers: angle model, speed regulator, and the flowchart's decisions."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_models.contract.current.records import SENSE
from drivegate_models.controllers.current.builtin import current_reference, initial_angle, regulate_speed
from drivegate_models.controllers.current.flowchart_search import decide_by_flowchart
from drivegate_models.controllers.current.following import decide_following, goes_on, tries_following
from drivegate_models.controllers.current.modes import begin_following, may_follow
from drivegate_models.controllers.current.protection import guard_regulation
from drivegate_models.controllers.current.state import (
    CONTROLLER_STATE,
    FOLLOWING,
    HOLDING,
    SEARCHING,
    SETTLING,
)
from drivegate_models.controllers.current.winding import has_lost_torque, unwind, unwind_after_recovery

pytestmark = pytest.mark.kernel
BASE = 500.0 * math.pi / 30.0


@given(st.floats(0.0, 400.0), st.floats(0.0, 1.0), st.floats(0.0, 0.02))
def test_initial_angle_is_zero_below_base_speed_and_a_line_above(
    speed: float, start: float, slope: float
) -> None:
    angle = initial_angle(speed, BASE, start, slope)
    if speed < BASE:
        assert angle == 0.0, f"{angle} rad at {speed} rad/s"
    else:
        assert angle == pytest.approx(min(start + slope * (speed - BASE), math.pi / 2.0))


@given(st.floats(-500.0, 500.0), st.floats(0.0, 26.0), st.floats(0.01, 50.0), st.floats(0.0, 5.0))
def test_the_regulator_stays_within_its_limit_and_does_not_wind_up(
    error: float, integral: float, proportional: float, step: float
) -> None:
    reference, following = regulate_speed(error, integral, proportional, step, 26.0)
    assert 0.0 <= reference <= 26.0
    assert 0.0 <= following <= 26.0
    if reference == 26.0 and error > 0.0 and proportional * error + integral > 26.0:
        assert following <= integral, "the integral grows into the limit"


def flowchart_state() -> Any:
    state = np.zeros(1, CONTROLLER_STATE).view(np.recarray)
    state["speed_tolerance"] = 0.5
    state["power_tolerance"] = 0.001
    state["step"] = 0.01
    state["direction"] = -1.0
    state["count"] = 200
    state["old_power"] = math.inf
    return state


@pytest.mark.parametrize(
    ("powers", "errors", "moves"),
    [
        pytest.param([40.0, 39.0, 38.0], [0.0] * 3, [-1, -1, -1], id="goes on while the power falls"),
        pytest.param([40.0, 39.0, 39.5, 39.0], [0.0] * 4, [-1, -1, 1, 1], id="reverses when it rose"),
        pytest.param([40.0, 40.01, 39.0], [0.0] * 3, [-1, 0, -1], id="stops within k2"),
        pytest.param([40.0, 39.0, 38.0], [0.0, 0.6, 0.0], [-1, 0, -1], id="inactive beyond k1"),
    ],
)
def test_decisions_of_the_flowchart(powers: list[float], errors: list[float], moves: list[int]) -> None:
    state = flowchart_state()
    made = []
    for power, error in zip(powers, errors, strict=True):
        state["power_sum"] = power * 200
        before = float(state["offset"][0])
        decide_by_flowchart(state[0], error)
        made.append(round((float(state["offset"][0]) - before) / 0.01))
    assert made == moves, f"Fig. 4 moves by {moves} steps, the search by {made}"


@pytest.mark.parametrize(
    ("current_sum", "left"),
    [pytest.param(24.0, 12.0, id="wound up in vain"), pytest.param(58.0, 29.0, id="a load that has grown")],
)
def test_a_regulator_unwinds_no_farther_than_to_the_current_that_flows(
    current_sum: float, left: float
) -> None:
    record = np.zeros(1, CONTROLLER_STATE).view(np.recarray)
    state: Any = record[0]
    state.mode, state.conducting_phases = SETTLING, 2
    state.good_power, state.good_integral, state.lost_speed = 22.0, 11.0, 1.0
    state.integral = 29.5
    assert unwind_after_recovery(state, current_sum)
    assert state.integral == left


@pytest.mark.parametrize(
    ("error", "lost"),
    [pytest.param(0.9, True, id="the speed stays away"), pytest.param(0.2, False, id="the speed returns")],
)
def test_a_higher_reference_is_lost_torque_only_where_the_speed_stays_away(error: float, lost: bool) -> None:
    record = np.zeros(1, CONTROLLER_STATE).view(np.recarray)
    state: Any = record[0]
    state.mode, state.conducting_phases, state.first_step = SEARCHING, 2, 0.02
    state.current_limit, state.speed_tolerance, state.calm_error = 26.0, 1.0, 0.01
    # A step of one degree down; the regulator has found 30 % more reference in a sag of 1 rad/s.
    state.moved, state.good_power, state.good_integral, state.rest_power = -0.02, 22.0, 11.0, math.inf
    state.integral, state.worst_error, state.error = 14.3, 1.0, error
    assert has_lost_torque(state, 21.8, 0.12) == lost, "at slightly less current"
    assert unwind(state, 21.8) == lost, "the step is reverted"


def following_state() -> Any:
    state = flowchart_state()
    state["angle_proportional"] = 0.01
    state["emf_over_supply"] = 1.3
    state["follows"] = 1
    state["offset"] = -0.1
    state["last_power"] = 30.0
    state["current_limit"] = 26.0
    state["conducting_phases"] = 4.0
    return state


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("angle_proportional", 0.0),
        ("emf_over_supply", 0.7),
        ("last_power", 5.0),
        ("follows", 0),
        ("compared", 1),
        ("offset", 0.0),
    ],
)
def test_the_angle_regulates_the_speed_only_where_the_emf_limits_the_current(
    field: str, value: float
) -> None:
    state = following_state()
    state["emf_over_supply"] = 1.1
    assert may_follow(state[0])
    state[field] = value
    assert not may_follow(state[0])


@pytest.mark.parametrize(
    ("found", "followed", "kept", "mode", "offset"),
    [
        pytest.param(30.0, 29.0, 31.0, FOLLOWING, 0.02, id="the free current is least"),
        pytest.param(30.0, 29.9, 30.0, FOLLOWING, 0.02, id="at equal currents the current is free"),
        pytest.param(30.0, 31.0, 28.0, HOLDING, -0.2, id="the angle before is least"),
        pytest.param(28.0, 31.0, 30.0, SEARCHING, 0.02, id="the search upward has found the least"),
    ],
)
def test_of_all_that_a_search_has_found_the_least_is_kept(
    found: float, followed: float, kept: float, mode: int, offset: float
) -> None:
    state = following_state()
    state["mode"], state["compared"], state["offset"] = SEARCHING, 1, 0.02
    state["followed_power"], state["kept_power"], state["kept_offset"] = followed, kept, -0.2
    assert goes_on(state[0], found) == (mode != SEARCHING)
    assert (state["mode"][0], state["offset"][0]) == (mode, offset)


@pytest.mark.parametrize(
    ("emf_over_supply", "share", "follows"),
    [(0.9, 0.25, True), (0.9, 0.17, False), (1.1, 0.1, True), (1.1, 0.04, False), (1.25, 0.04, True)],
)
def test_the_lower_the_emf_the_heavier_is_the_load_that_frees_the_current(
    emf_over_supply: float, share: float, follows: bool
) -> None:
    state = following_state()
    state["emf_over_supply"], state["last_power"] = emf_over_supply, share * 4.0 * 26.0
    assert may_follow(state[0]) == follows


@pytest.mark.parametrize(
    ("current_sum", "mode"),
    [pytest.param(30.0, SETTLING, id="searched upward"), pytest.param(15.0, FOLLOWING, id="a light load")],
)
def test_a_search_goes_upward_from_the_regulated_angle_unless_the_load_is_light(
    current_sum: float, mode: int
) -> None:
    state = following_state()
    begin_following(state[0])
    state["emf_over_supply"], state["last_power"], state["lowest"] = 1.1, current_sum, -1.0
    state["followed_power"] = math.inf
    for _ in range(3):
        decide_following(state[0], current_sum, True)
    assert (state["mode"][0], state["followed_power"][0]) == (mode, current_sum)


def test_the_search_goes_on_from_where_it_was_after_an_angle_that_could_not_regulate_the_speed() -> None:
    state = following_state()
    assert tries_following(state[0], 30.0)
    state["angle_integral"] = state["lowest"] = -0.9
    decide_following(state[0], 12.0, True)
    found = (state["mode"][0], state["offset"][0], state["follows"][0])
    assert found == (SETTLING, -0.1, 0), "the angle is not held, and not searched for from the beginning"


def test_a_search_that_ends_inside_tries_a_free_current_only_above_the_supply() -> None:
    for emf_over_supply, tries in ((0.95, False), (1.05, True)):
        state = following_state()
        state["emf_over_supply"] = emf_over_supply
        assert goes_on(state[0], 30.0) == tries
        assert (state["mode"][0] == FOLLOWING) == tries


def test_only_a_lasting_loss_of_speed_ends_the_regulation_by_the_angle() -> None:
    """Single wrong readings, of an encoder with a false count, do not."""
    state = following_state()
    state["speed_reference"] = 200.0
    state["proportional"] = 1.0
    begin_following(state[0])
    for k in range(100):
        sag = 60.0 if k % 10 == 0 else 0.0
        guard_regulation(state[0], 200.0 - sag, 200.0, 0.0, 40.0, 26.0, 1e-3)
    assert state["mode"][0] == FOLLOWING
    for _ in range(25):
        guard_regulation(state[0], 140.0, 200.0, 0.0, 40.0, 26.0, 1e-3)
    assert state["mode"][0] == SETTLING
    assert not may_follow(state[0]), "it is not tried again under this load"


@pytest.mark.parametrize(("advancing", "reference"), [(1, 26.0), (0, 0.0)])
def test_below_base_speed_the_current_regulates_the_speed(advancing: int, reference: float) -> None:
    state = following_state()
    begin_following(state[0])
    state["advancing"] = advancing
    state["freed_reference"] = 26.0
    state["proportional"] = 1.0
    sense = np.zeros(1, SENSE).view(np.recarray)
    sense["speed"], sense["speed_reference"] = 100.0, 50.0
    assert current_reference(state[0], sense[0]) == reference
