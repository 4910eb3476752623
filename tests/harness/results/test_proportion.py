"""Intervals of probabilities against values known from elsewhere."""

import numpy as np
import pytest

from drivegate.results.proportion import proportion


@pytest.mark.parametrize(
    ("happened", "runs", "low", "high"),
    [
        # Clopper and Pearson's interval in closed form where nothing, or everything, happens.
        (0, 10, 0.0, 1.0 - 0.025 ** (1 / 10)),
        (10, 10, 0.025 ** (1 / 10), 1.0),
        (0, 1000, 0.0, 1.0 - 0.025 ** (1 / 1000)),
        # Tabulated for 5 of 10, and for 1 of 20.
        (5, 10, 0.1871, 0.8129),
        (1, 20, 0.0013, 0.2487),
    ],
)
def test_intervals_agree_with_known_values(happened, runs, low, high):
    found = proportion(happened, runs)
    assert found.estimate == happened / runs
    assert found.low == pytest.approx(low, abs=6e-5)
    assert found.high == pytest.approx(high, abs=6e-5)


def test_the_interval_covers_the_truth_as_often_as_it_says():
    draws = np.random.default_rng(1).binomial(50, 0.1, 400)
    found = [proportion(int(happened), 50, 0.9) for happened in draws]
    covered = sum(interval.low <= 0.1 <= interval.high for interval in found)
    assert covered >= 0.9 * 400, "an exact interval covers at least as often as its confidence"


def test_more_confidence_is_a_wider_interval_and_nothing_is_known_without_runs():
    assert proportion(3, 30, 0.99).high > proportion(3, 30, 0.9).high
    nothing = proportion(0, 0)
    assert (nothing.estimate, nothing.low, nothing.high) == (None, 0.0, 1.0)
