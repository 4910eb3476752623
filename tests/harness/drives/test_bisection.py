"""Halving finds where a condition ceases to be met, from either side."""

from __future__ import annotations

import pytest

from drivegate.drives.constant_power import last_met

EDGE = 3.3


@pytest.mark.parametrize("missed", [8.0, -8.0])
def test_the_value_found_meets_the_condition_and_lies_within_a_last_half(missed: float) -> None:
    met, halvings = 2.0 * EDGE - missed, 12

    def is_met(value: float) -> bool:
        return value <= EDGE if missed > EDGE else value >= EDGE

    found = last_met(is_met, met, missed, halvings)
    assert is_met(found), f"{found} does not meet the condition"
    assert abs(found - EDGE) <= abs(met - missed) / 2**halvings, f"{found} is too far from {EDGE}"


def test_without_halvings_the_given_value_stays() -> None:
    assert last_met(lambda value: value < EDGE, 1.0, 5.0, 0) == 1.0
