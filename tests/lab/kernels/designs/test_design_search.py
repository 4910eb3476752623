"""The searches of the correct designs, on a current sum that is known: an optimum, or an edge without torque."""

import math
from typing import Any

import numpy as np
import pytest

from drivegate_lab.kernels.designs.confirmation import (
    AT_ANGLE,
    UNCONFIRMED,
    begin_confirmation,
    continue_confirmation,
    lowest_rest,
)
from drivegate_lab.kernels.designs.probe import aim, approach
from drivegate_lab.kernels.designs.rest import begin_watch, is_rest_confirmed
from drivegate_lab.kernels.designs.search import (
    LONGEST_SEARCH,
    MOST_DECISIONS,
    begin_search,
    fall_back_to_table,
    next_probe,
    record_cheapest,
    set_target,
    should_fall_back_to_table,
)
from drivegate_lab.kernels.designs.state import (
    ANGLE_TABLE,
    DESIGN_STATE,
    GOLDEN_SECTION,
    QUADRATIC_INTERPOLATION,
    SWEEP,
)
from drivegate_lab.kernels.designs.table_values import ANGLES_DEG, CURRENT_SUMS

pytestmark = pytest.mark.kernel
SEARCHES = (GOLDEN_SECTION, QUADRATIC_INTERPOLATION, SWEEP)
LINE = math.radians(55.0)


def design_state(design: int) -> Any:
    state = np.zeros(1, DESIGN_STATE).view(np.recarray)[0]
    state.design = design
    state.line = LINE
    state.controller.first_step = math.radians(1.0)
    state.controller.step = math.radians(1.0)
    state.controller.forbidden = state.controller.lost_at = -math.inf
    return state


def current_sum(angle: float, optimum: float) -> float:
    return 20.0 + 60.0 * (angle - optimum) ** 2


def searched(design: int, optimum_deg: float, edge_deg: float) -> tuple[Any, list[float]]:
    """Let a design search, and return its state and all angles probed, in degrees."""
    state = design_state(design)
    optimum, edge = math.radians(optimum_deg), math.radians(edge_deg)
    state.controller.last_power = current_sum(LINE, optimum)
    set_target(state, begin_search(state))
    probed: list[float] = []
    while state.finished == 0 and len(probed) < MOST_DECISIONS:
        angle = LINE + state.target
        probed.append(math.degrees(angle))
        if angle < edge:
            state.controller.forbidden = state.target
            set_target(state, state.target)
            continue
        state.controller.offset = state.target
        state.controller.last_power = current_sum(angle, optimum)
        state.controller.worst_error = 0.0
        record_cheapest(state)
        set_target(state, next_probe(state, float(state.controller.last_power)))
    return state, probed


@pytest.mark.parametrize("design", SEARCHES)
@pytest.mark.parametrize("optimum_deg", [12.0, 30.0, 45.0])
def test_a_search_finds_an_optimum_within_its_bracket(design: int, optimum_deg: float) -> None:
    state, probed = searched(design, optimum_deg, 0.0)
    assert state.finished == 1, probed
    assert math.degrees(LINE + state.target) == pytest.approx(optimum_deg, abs=2.0), probed


@pytest.mark.parametrize("design", SEARCHES)
@pytest.mark.parametrize("edge_deg", [25.3, 40.1, 53.0])
def test_a_search_rests_close_above_an_edge(design: int, edge_deg: float) -> None:
    state, probed = searched(design, 10.0, edge_deg)
    assert state.finished == 1, probed
    rest = math.degrees(LINE + state.target)
    assert edge_deg <= rest <= edge_deg + 2.5, (rest, probed)


def test_searches_probe_different_angles() -> None:
    probed = [tuple(searched(design, 30.0, 0.0)[1]) for design in SEARCHES]
    assert len(set(probed)) == len(SEARCHES), probed


@pytest.mark.parametrize("design", SEARCHES)
@pytest.mark.parametrize("found_deg", [23.0, 28.0, 36.0])
def test_what_was_found_under_another_load_is_left_for_a_cheaper_neighbour(
    design: int, found_deg: float
) -> None:
    state = design_state(design)
    optimum = math.radians(30.0)
    state.best_offset = math.radians(found_deg) - LINE
    state.controller.offset = begin_confirmation(state)
    probes = 0
    while state.finished == 0 and probes < MOST_DECISIONS:
        state.controller.last_power = current_sum(LINE + state.controller.offset, optimum)
        state.controller.offset = continue_confirmation(state, float(state.controller.last_power))
        probes += 1
    assert state.finished == 1
    assert math.degrees(LINE + state.best_offset) == pytest.approx(30.0, abs=1.6), probes


@pytest.mark.parametrize("design", [*SEARCHES, ANGLE_TABLE])
@pytest.mark.parametrize(("current_sum_a", "searches"), [(20.0, False), (22.0, True)])
def test_a_load_too_light_to_search_by_is_looked_up(
    design: int, current_sum_a: float, searches: bool
) -> None:
    first = {}
    for which in (design, ANGLE_TABLE):
        first[which] = first_offset(which, current_sum_a)
    same = bool(first[design] == first[ANGLE_TABLE])
    assert same is (design == ANGLE_TABLE or not searches), first


@pytest.mark.parametrize("design", [*SEARCHES, ANGLE_TABLE])
def test_at_light_load_the_angle_is_that_of_the_drives_own_table(design: int) -> None:
    here, there = (first_offset(design, 20.0, higher_deg=higher) for higher in (0.0, 3.0))
    assert there - here == pytest.approx(math.radians(3.0))


@pytest.mark.parametrize("design", SEARCHES)
@pytest.mark.parametrize(
    ("current_sum_a", "decisions", "confirming", "given_up"),
    [
        (22.0, LONGEST_SEARCH - 1, UNCONFIRMED, False),
        (22.0, LONGEST_SEARCH, UNCONFIRMED, True),
        (22.0, LONGEST_SEARCH, AT_ANGLE, False),
        (20.0, 5, UNCONFIRMED, True),
        (20.0, 5, AT_ANGLE, True),
    ],
)
def test_a_search_without_time_or_current_is_given_up_for_the_table(
    design: int, current_sum_a: float, decisions: int, confirming: int, given_up: bool
) -> None:
    state = loaded_state(design, 40.0)
    begin_search(state)
    assert state.tabled == 0
    state.decisions, state.confirming = decisions, confirming
    state.controller.last_power = current_sum_a
    assert bool(should_fall_back_to_table(state)) is given_up
    if given_up:
        assert fall_back_to_table(state) == first_offset(ANGLE_TABLE, current_sum_a)
        assert not should_fall_back_to_table(state), "once is enough"


def test_a_rest_keeps_off_the_edge_that_a_small_step_has_shown() -> None:
    controller = loaded_state(SWEEP, 40.0).controller
    controller.forbidden, controller.lost_at = math.radians(-20.0), -math.inf
    assert math.degrees(lowest_rest(controller)) == pytest.approx(-20.0 + 0.8), "all that is known"
    controller.lost_at = math.radians(-21.0)
    assert math.degrees(lowest_rest(controller)) == pytest.approx(-20.5 + 0.8)
    controller.lost_at = math.radians(-24.0)
    assert lowest_rest(controller) >= controller.forbidden, "what is forbidden is never returned to"


def test_no_angle_is_gone_to_aside_that_costs_more_than_the_optimum_allows() -> None:
    state = loaded_state(GOLDEN_SECTION, 10.0)
    state.best_power = 10.0
    state.controller.worst_error = math.inf
    for power, goes in ((10.05, True), (10.07, False)):
        state.controller.offset = state.target = 0.0
        state.controller.last_power = power
        begin_watch(state)
        for _ in range(3):
            is_rest_confirmed(state)
        assert bool(state.target > 0.0) is goes, power


def loaded_state(design: int, current_sum_a: float) -> Any:
    """Return the state of a design at a current sum of the paper's drive at 1430 rpm, with the drive's table."""
    state = design_state(design)
    state.table_from, state.table_step = 500.0 * math.pi / 30.0, 50.0 * math.pi / 30.0
    state.table_sums, state.table_angles = CURRENT_SUMS, np.radians(np.array(ANGLES_DEG))
    state.controller.base_speed = 500.0 * math.pi / 30.0
    state.controller.rated_sum = 1500.0 / 48.0
    state.controller.conducting_phases, state.controller.current_limit = 4.0, 26.0
    state.controller.nominal_voltage = state.controller.supply_voltage = 48.0
    state.controller.speed_tolerance = 5.0 * math.pi / 30.0
    state.speed = 1430.0 * math.pi / 30.0
    state.controller.last_power = current_sum_a
    return state


def first_offset(design: int, current_sum_a: float, *, higher_deg: float = 0.0) -> float:
    """Begin a search at a current sum of the paper's drive at 1430 rpm."""
    state = loaded_state(design, current_sum_a)
    state.table_angles = np.radians(np.array(ANGLES_DEG) + higher_deg)
    return float(begin_search(state))


def test_a_speed_that_never_calms_is_no_place_to_rest() -> None:
    state = design_state(GOLDEN_SECTION)
    state.controller.conducting_phases, state.controller.current_limit = 4.0, 26.0
    state.controller.speed_tolerance = 5.0 * math.pi / 30.0
    state.controller.last_power = state.best_power = 3.4
    state.controller.worst_error = 0.07 * math.pi / 30.0
    begin_watch(state)
    rests = [is_rest_confirmed(state) for _ in range(3)]
    assert rests == [False, False, False]
    assert state.target > 0.0, "an angle a little higher is tried"
    state.controller.worst_error = 0.01 * math.pi / 30.0
    rests = [is_rest_confirmed(state) for _ in range(15)]
    assert rests == [*[False] * 14, True], "at light load the current sum takes long to settle"


def test_an_angle_is_approached_by_steps_that_can_be_given_back() -> None:
    state = design_state(GOLDEN_SECTION)
    aim(state, math.radians(-11.0))
    steps = []
    while abs(state.target - state.controller.offset) > 1e-9:
        approach(state)
        steps.append(math.degrees(state.controller.moved))
    assert sum(steps) == pytest.approx(-11.0)
    assert steps[:2] == pytest.approx([-1.0, -1.0]), "careful at first"
    assert min(steps) >= -2.0 - 1e-9, steps
    assert max(steps) < -0.5, "a step that were tiny would be no way back"


@pytest.mark.parametrize(
    ("home_sum_a", "retries"),
    [
        pytest.param(70.0, True, id="the sum falls by 2 % a degree"),
        pytest.param(58.0, False, id="the sum falls by 0.8 % a degree"),
    ],
)
def test_an_edge_found_by_a_long_stride_is_looked_for_again_where_its_distance_costs_much(
    home_sum_a: float, retries: bool
) -> None:
    state = design_state(QUADRATIC_INTERPOLATION)
    state.home, state.home_power = 0.0, home_sum_a
    state.best_offset, state.best_power = math.radians(-20.0), 50.0
    state.controller.offset = state.best_offset
    state.controller.forbidden, state.controller.lost_at = math.radians(-20.5), -math.inf
    begin_confirmation(state)
    assert (state.controller.retried == 1) == retries
    # 3 degrees below are allowed again: small steps farther would have no time.
    assert math.degrees(state.controller.forbidden) == pytest.approx(-23.5 if retries else -20.5)
