"""The yardstick from outside counts what it says: flights within the ranges, and simulations until a collision."""

from math import dist, pi

import pytest

from f16_yardstick import ALLOWANCE, ANGLES, LeastAltitude, angles, row, runs_to_collision
from search_methods import METHODS, random_points

CORNER = (0.9, 0.1, 0.2)


def test_the_ends_of_the_cube_are_the_ranges_of_the_example() -> None:
    assert angles((0.0, 0.0, 0.0)) == pytest.approx((0.2 * pi, -0.4 * pi, -0.375 * pi))
    assert angles((1.0, 1.0, 1.0)) == pytest.approx((17.0 * pi / 60.0, -0.35 * pi, -0.125 * pi))
    assert len(ANGLES) == 3


def test_a_trial_counts_the_simulations_up_to_the_collision() -> None:
    runs = runs_to_collision(lambda point: dist(point, CORNER) - 0.3, METHODS["shard"], 1)
    assert runs is not None
    assert 1 <= runs < ALLOWANCE
    assert runs_to_collision(lambda _: 1.0, random_points, 1) is None


def test_a_row_counts_what_was_not_found_as_more_than_the_allowance() -> None:
    assert row("shard", [10, 20, None]) == "| shard | 2 of 3 | 20 | 15 |"
    assert row("shard", [10, None, None]) == f"| shard | 1 of 3 | {ALLOWANCE + 1} | 10 |"
    assert row("shard", [None]) == "| shard | 0 of 1 | – | – |"


def test_a_flight_without_the_model_says_what_is_missing() -> None:
    with pytest.raises(ModuleNotFoundError, match="aerobench"):
        LeastAltitude("/nowhere")((0.5, 0.5, 0.5))
