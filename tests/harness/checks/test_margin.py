"""How a margin is written for people."""

import pytest

from drivegate.checks.margin import GREATEST, margin_in_words


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.6213, "+0.621"),
        (-0.5, "-0.5"),
        (10.0, "+10"),
        (-10.001, "beyond -10"),
        (-GREATEST, "beyond -10"),
        (55.9, "beyond +10"),
    ],
)
def test_a_margin_beyond_ten_limits_is_written_as_that(value: float, words: str) -> None:
    assert margin_in_words(value) == words
