"""Numbers in tables."""

import pytest

from drivegate.output.console import number


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (-0.0, 2, "0.00"),
        (-0.004, 2, "0.00"),
        (-0.4, 0, "0"),
        (-0.006, 2, "-0.01"),
        (1.5, 1, "1.5"),
        (None, 2, "–"),
    ],
)
def test_a_number_that_rounds_to_zero_has_no_sign(value: float | None, digits: int, text: str) -> None:
    assert number(value, digits) == text
