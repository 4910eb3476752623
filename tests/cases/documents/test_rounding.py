"""Numbers keep as many digits as people would write, whatever their size."""

from __future__ import annotations

import math

import pytest

from drivegate_cases.documents.wording import significant


@pytest.mark.parametrize(
    ("value", "digits", "rounded"),
    [
        (123456.0, 2, 120000.0),
        (0.00123456, 3, 0.00123),
        (-9.996, 3, -10.0),
        (0.0, 4, 0.0),
        (1e300, 1, 1e300),
        (7.0, 6, 7.0),
    ],
)
def test_digits_count_from_the_first_that_is_not_zero(value: float, digits: int, rounded: float) -> None:
    assert significant(value, digits) == rounded


def test_what_is_no_number_stays_none() -> None:
    assert math.isnan(significant(math.nan, 3))
    assert significant(math.inf, 3) == math.inf
