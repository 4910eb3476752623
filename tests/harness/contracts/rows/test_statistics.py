"""Statistics over stretches agree with a plain loop over all of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate.contracts.rows.statistics import MEASURES, place_reached

PLAIN: dict[str, Callable[[list[float]], float]] = {
    "mean": lambda part: math.fsum(part) / len(part),
    "rms": lambda part: math.sqrt(math.fsum(value * value for value in part) / len(part)),
    "peak to peak": lambda part: max(part) - min(part),
}
VALUES = st.lists(st.integers(-8, 8).map(float), min_size=1, max_size=30)


def stretches(values: list[float], length: int) -> list[list[float]]:
    length = length or len(values)
    return [values[start : start + length] for start in range(len(values) - length + 1)]


@pytest.mark.parametrize("name", PLAIN)
@given(values=VALUES, data=st.data())
def test_a_statistic_is_that_of_every_stretch(name: str, values: list[float], data: st.DataObject) -> None:
    length = data.draw(st.integers(0, len(values)))
    found = MEASURES[name](np.array(values), length)
    plain = [PLAIN[name](part) for part in stretches(values, length)]
    assert found.low == pytest.approx(min(plain), abs=1e-6)
    assert found.high == pytest.approx(max(plain), abs=1e-6)


@given(values=VALUES, data=st.data())
def test_a_value_counts_where_it_lasts(values: list[float], data: st.DataObject) -> None:
    length = data.draw(st.integers(1, len(values)))
    found = MEASURES["value"](np.array(values), length)
    assert found.high == max(min(part) for part in stretches(values, length))
    assert found.low == min(max(part) for part in stretches(values, length))
    assert MEASURES["absolute"](np.array(values), 0).high == max(map(abs, values))
    peak = MEASURES["peak"](np.array(values), length)
    assert peak.low == peak.high == max(min(map(abs, part)) for part in stretches(values, length))


@given(values=VALUES, data=st.data())
def test_sign_changes_are_counted_past_zeros(values: list[float], data: st.DataObject) -> None:
    found = MEASURES["sign changes"](np.array(values), 0)
    signs = [math.copysign(1.0, value) for value in values if value]
    assert found.high == sum(before != after for before, after in pairwise(signs))
    length = data.draw(st.integers(1, len(values)))
    most = MEASURES["sign changes"](np.array(values), length).high
    plain = [MEASURES["sign changes"](np.array(part), 0).high for part in stretches(values, length)]
    # A zero at the begin of a stretch has the sign of what came before, which the stretch alone does not show.
    assert max(plain) <= most <= found.high


@given(values=VALUES, data=st.data())
def test_a_range_is_reached_where_values_stay_in_it(values: list[float], data: st.DataObject) -> None:
    inside = [-2.0 <= value <= 3.0 for value in values]
    settled = next((place for place in range(len(values)) if all(inside[place:])), None)
    assert place_reached(np.array(values), -2.0, 3.0, None) == settled
    length = data.draw(st.integers(1, len(values)))
    held = next(
        (place for place in range(len(values) - length + 1) if all(inside[place : place + length])), None
    )
    assert place_reached(np.array(values), -2.0, 3.0, length) == held
