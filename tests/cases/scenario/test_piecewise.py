from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.scenario.piecewise import Profile, breakpoints, check_times, value_from, value_until

STEP: Profile = ((0.0, 10.0), (1.0, 10.0), (1.0, 20.0), (2.0, 40.0))


@pytest.mark.parametrize(
    ("time", "until", "after"),
    [
        (0.0, 10.0, 10.0),
        (0.5, 10.0, 10.0),
        (1.0, 10.0, 20.0),
        (1.5, 30.0, 30.0),
        (2.0, 40.0, 40.0),
        (9.0, 40.0, 40.0),
    ],
)
def test_values_ahead_of_a_step_and_behind_it(time: float, until: float, after: float) -> None:
    assert value_until(STEP, time) == until
    assert value_from(STEP, time) == after


@pytest.mark.parametrize(
    ("profile", "reported"),
    [
        ((), "first point at time 0"),
        (((0.1, 1.0),), "first point at time 0"),
        (((-1.0, 1.0), (0.0, 1.0)), "first point at time 0"),
        (((0.0, 1.0), (2.0, 1.0), (1.5, 1.0)), "the point at 1.5 s"),
        (((0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (1.0, 3.0)), "has more at 1.0 s"),
    ],
)
def test_disordered_times_are_reported(profile: Profile, reported: str) -> None:
    with pytest.raises(ValueError, match=reported):
        check_times(profile)


def test_ordered_times_are_fine() -> None:
    assert check_times(STEP) == STEP


def test_breakpoints_are_merged_up_to_the_end() -> None:
    assert breakpoints([STEP, ((0.0, 1.0), (1.5, 2.0))], 1.75) == [0.0, 1.0, 1.5, 1.75]


TIMES = st.lists(st.integers(1, 1000), min_size=1, max_size=6, unique=True).map(sorted)


@given(TIMES, st.data())
def test_without_steps_a_profile_is_plain_interpolation(times: list[int], data: st.DataObject) -> None:
    instants = [0.0, *[time / 100.0 for time in times]]
    values = data.draw(st.lists(st.floats(-1e3, 1e3), min_size=len(instants), max_size=len(instants)))
    profile = tuple(zip(instants, values, strict=True))
    for earlier, later in pairwise([*instants, instants[-1] + 1.0]):
        middle = 0.5 * (earlier + later)
        expected = pytest.approx(float(np.interp(middle, instants, values)), abs=1e-9)
        assert value_from(profile, middle) == expected
        assert value_until(profile, middle) == expected
