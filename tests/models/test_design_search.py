"""The searches of the correct designs, on a current sum that is known: an optimum, or an edge without torque."""

import math
from typing import Any

import numpy as np
import pytest

from drivegate_models.angle_probe import aim, approach
from drivegate_models.design_search import MOST_DECISIONS, begin_search, next_probe, note_cheapest, settle_for
from drivegate_models.design_state import (
    DESIGN_STATE,
    GOLDEN_SECTION,
    QUADRATIC_INTERPOLATION,
    SLOPE_BISECTION,
    SWEEP,
)

pytestmark = pytest.mark.kernel
SEARCHES = (GOLDEN_SECTION, QUADRATIC_INTERPOLATION, SLOPE_BISECTION, SWEEP)
LINE = math.radians(55.0)


def design_state(design: int) -> Any:
    state = np.zeros(1, DESIGN_STATE).view(np.recarray)[0]
    state.design = design
    state.line = LINE
    state.controller.first_step = math.radians(1.0)
    state.controller.step = math.radians(1.0)
    state.controller.forbidden = -math.inf
    return state


def current_sum(angle: float, optimum: float) -> float:
    return 20.0 + 60.0 * (angle - optimum) ** 2


def searched(design: int, optimum_deg: float, edge_deg: float) -> tuple[Any, list[float]]:
    """Let a design search, and return its state and all angles probed, in degrees."""
    state = design_state(design)
    optimum, edge = math.radians(optimum_deg), math.radians(edge_deg)
    state.controller.last_power = current_sum(LINE, optimum)
    settle_for(state, begin_search(state))
    probed: list[float] = []
    while state.finished == 0 and len(probed) < MOST_DECISIONS:
        angle = LINE + state.target
        probed.append(math.degrees(angle))
        if angle < edge:
            state.controller.forbidden = state.target
            settle_for(state, state.target)
            continue
        state.controller.offset = state.target
        state.controller.last_power = current_sum(angle, optimum)
        state.controller.worst_error = 0.0
        note_cheapest(state)
        settle_for(state, next_probe(state, float(state.controller.last_power)))
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
