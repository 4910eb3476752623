"""The search for minimum power: to the least of a steady one, and not astray where something else changes it."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, pi, sin

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.models.controllers.duty.test_plausibility import BASE_SPEED, NAMEPLATE, PERIOD, RATED_TORQUE
from tests.models.controllers.duty.test_speed_regulator import reset_with

from drivegate_models.controllers.duty.loss_search import searched_offset

pytestmark = pytest.mark.kernel
LIMIT = NAMEPLATE.current_limit


def last_offsets(
    power: Callable[[float, float], float], speed: float, duration: float
) -> NDArray[np.float64]:
    """Return the offsets (A) in the last 0.2 s of a search on a power (W) of time (s) and offset (A)."""
    state = reset_with("foc-loss-search")
    offset, offsets = 0.0, []
    for k in range(round(duration / PERIOD)):
        offset = searched_offset(state, 0.5 * RATED_TORQUE, speed, power(k * PERIOD, offset))
        offsets.append(offset)
    return np.array(offsets[-round(0.2 / PERIOD) :])


@pytest.mark.parametrize("least", [0.0, 0.005, 0.0137, 0.05, 0.1, 0.3, 0.45])
def test_a_steady_power_is_brought_to_its_least(least: float) -> None:
    best = -least * LIMIT
    found = last_offsets(lambda _, offset: 300.0 + (offset - best) ** 2, BASE_SPEED, 1.5)
    assert abs(found.mean() - best) < 0.012 * LIMIT, f"{found.mean():.3f} A, {best:.3f} A is best"


@pytest.mark.parametrize(("rise", "constant"), [(1.0, 0.3), (10.0, 0.1), (30.0, 0.2), (100.0, 0.15)])
def test_a_power_that_rises_with_the_load_does_not_lead_the_search_astray(
    rise: float, constant: float
) -> None:
    """The load of a fan rises while the speed settles, by less and less."""
    found = last_offsets(
        lambda time, offset: 300.0 - rise * exp(-time / constant) + offset**2, BASE_SPEED, 1.2
    )
    assert abs(found.mean()) < 0.012 * LIMIT, f"{found.mean():.3f} A, 0 is best"


@pytest.mark.parametrize("share", [0.5, 0.9, -0.9])
def test_nothing_is_tried_where_a_sixth_of_a_cycle_lasts_too_long_to_average_over(share: float) -> None:
    speed = share * pi / 3.0 / (NAMEPLATE.pole_pairs * 0.06)
    around = 6.0 * NAMEPLATE.pole_pairs * speed
    offsets = last_offsets(lambda time, offset: 300.0 + 3.0 * sin(around * time) + offset**2, speed, 1.0)
    assert not offsets.any()


def test_a_search_that_begins_adds_little_current() -> None:
    """It begins wherever the torque has changed; FWK-2 allows as much."""
    begun = last_offsets(lambda _, offset: 300.0 + offset**2, BASE_SPEED, 0.2)
    assert -0.03 * LIMIT <= begun.min() < 0.0
