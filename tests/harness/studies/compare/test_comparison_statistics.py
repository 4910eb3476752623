"""Paired differences against known cases."""

import math

import numpy as np
import pytest
from scipy import stats

from drivegate.studies.compare.ranking import NO_DIFFERENCE, paired_difference

# Student's own example (Cushny and Peebles): hours of sleep gained with two drugs by ten patients.
DEXTRO = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
LAEVO = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]


def test_student_s_own_example():
    made = paired_difference(DEXTRO, LAEVO)
    assert made["pairs"] == 10
    assert made["mean_difference"] == pytest.approx(-1.58)
    assert made["low"] == pytest.approx(-2.4598858, abs=1e-6)
    assert made["high"] == pytest.approx(-0.7001142, abs=1e-6)
    assert made["verdict"] == "first lower"


def test_the_interval_is_the_library_s():
    expected = stats.ttest_rel(DEXTRO, LAEVO).confidence_interval(1.0 - 0.05 / 6)
    made = paired_difference(DEXTRO, LAEVO, intervals=6)
    assert (made["low"], made["high"]) == pytest.approx((expected.low, expected.high))


def test_more_intervals_are_wider():
    alone, among_ten = (paired_difference(DEXTRO, LAEVO, intervals=count) for count in (1, 10))
    assert among_ten["low"] < alone["low"] < alone["high"] < among_ten["high"]


def test_noise_alone_is_no_real_difference():
    generator = np.random.default_rng(1)
    first = (100.0 + generator.normal(0.0, 1.0, 40)).tolist()
    second = (100.0 + generator.normal(0.0, 1.0, 40)).tolist()
    assert paired_difference(first, second)["verdict"] == NO_DIFFERENCE


def test_false_alarms_are_as_rare_as_promised():
    generator = np.random.default_rng(7)
    alarms = 0
    for _ in range(400):
        changes = generator.normal(0.0, 1.0, 8)
        alarms += paired_difference(changes.tolist(), [0.0] * 8)["verdict"] != NO_DIFFERENCE
    assert alarms / 400 == pytest.approx(0.05, abs=0.03), "95 % confidence must be right 95 % of the time"


def test_a_certain_difference_that_does_not_matter_is_no_real_one():
    first = [1000.0, 1001.0, 1002.0, 1003.0]
    made = paired_difference([value + 0.5 for value in first], first)
    assert made["low"] == made["high"] == pytest.approx(0.5)
    assert made["verdict"] == NO_DIFFERENCE, "half a watt of a kilowatt is below the least effect"
    assert paired_difference([value + 2.0 for value in first], first)["verdict"] == "first higher"


@pytest.mark.parametrize("pairs", [0, 1, 2])
def test_too_few_pairs_have_no_interval(pairs):
    made = paired_difference([2.0] * pairs, [1.0] * pairs)
    assert made["verdict"] == "too few pairs"
    assert made["low"] is None
    assert made["high"] is None
    assert (made["mean_difference"] is None) == (pairs == 0)


def test_all_zero_is_no_difference():
    made = paired_difference([0.0] * 5, [0.0] * 5)
    assert made["verdict"] == NO_DIFFERENCE
    assert made["relative_percent"] is None
    assert math.isfinite(made["low"])
