"""Numbers as sheets print them are read, and what may mean two numbers is known for it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.documents.quantity.numbers import leading_number, without_power


@pytest.mark.parametrize(
    ("text", "value", "rest"),
    [
        ("0,42 ohm", 0.42, " ohm"),
        ("11000rpm", 11000.0, "rpm"),
        ("11 000 rpm", 11000.0, " rpm"),
        ("1'250 W", 1250.0, " W"),
        ("1.234.567 rpm", 1234567.0, " rpm"),
        ("1,234.5", 1234.5, ""),
        ("1.234,5", 1234.5, ""),
        ("0.31x10-4", 0.31e-4, ""),
        ("0.31 × 10^-4 kg", 0.31e-4, " kg"),
        ("0.31·10**-4", 0.31e-4, ""),
        ("10^-4 kg", 1e-4, " kg"),
        ("1.5 x10^3 rpm", 1500.0, " rpm"),
        ("3.1E-05", 3.1e-5, ""),
        (".5 A", 0.5, " A"),
    ],
)
def test_a_number_and_what_follows_it(text: str, value: float, rest: str) -> None:
    found = leading_number(text)
    assert found is not None
    assert (found[0].value, found[1]) == (value, rest)


@pytest.mark.parametrize("text", ["", "ohm", "-1", "1.2.3", "1,2,3", "1,234,5", "5,"])
def test_what_is_no_number(text: str) -> None:
    assert leading_number(text) is None


@pytest.mark.parametrize(("text", "grouped"), [("4.600", 4600.0), ("4,600", 4600.0), ("12,000", 12000.0)])
def test_three_digits_after_a_separator_may_be_thousands(text: str, grouped: float) -> None:
    found = leading_number(text)
    assert found is not None
    assert found[0].grouped == grouped


@pytest.mark.parametrize("text", ["0.600", "0,600", "4600", "4.60", "4.6000", "1.155e-3", "1155.123"])
def test_other_separators_are_decimal(text: str) -> None:
    found = leading_number(text)
    assert found is not None
    assert found[0].grouped is None


@given(st.floats(min_value=1e-9, max_value=1e9))
def test_whatever_python_writes_is_read_as_that(value: float) -> None:
    found = leading_number(repr(value))
    assert found is not None
    assert (found[0].value, found[1]) == (value, "")


def test_a_power_of_ten_at_the_end_of_a_unit_is_one_of_the_number() -> None:
    assert without_power("kg·m^2 (×10^-4)") == ("kg·m^2", -4)
    assert without_power("kg.m2 x10-4") == ("kg.m2", -4)
    # In the head of a column, a positive power is one of the number's inverse.
    assert without_power("kg·m^2 ×10^4") == ("kg·m^2 ×10^4", 0)
