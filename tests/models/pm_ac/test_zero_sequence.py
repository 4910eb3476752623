"""Duty ratios of each kind of modulation: the same line-to-line voltages, and the leg that its name says is clamped."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivegate_models.pm_ac.modulation_kind import (
    CONTINUOUS,
    DPWM_0,
    DPWM_1,
    DPWM_2,
    DPWM_3,
    DPWM_MAX,
    DPWM_MIN,
    MODULATION_NUMBERS,
)
from drivegate_models.pm_ac.zero_sequence import clamped_rail, write_ratios

pytestmark = pytest.mark.kernel

LINK = 48.0
AXES = np.array([0.0, 2.0 * pi / 3.0, -2.0 * pi / 3.0])


def ratios_of(kind: int, angle: float, size: float = 0.8, sense: float = 1.0) -> NDArray[np.float64]:
    """Return the duty ratios of a voltage at an angle, of a size over the greatest undistorted one."""
    along, across = (size * LINK / sqrt(3.0) * turn(angle) for turn in (cos, sin))
    ratios = np.zeros(3)
    write_ratios(ratios, along, across, LINK, clamped_rail(kind, along, across, sense))
    return ratios


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", MODULATION_NUMBERS.values(), ids=MODULATION_NUMBERS)
@given(angle=st.floats(-pi, pi), size=st.floats(0.0, 1.0), sense=st.sampled_from([1.0, -1.0]))
def test_each_kind_has_the_voltage_that_is_asked_for(
    kind: int, angle: float, size: float, sense: float
) -> None:
    ratios = ratios_of(kind, angle, size, sense)
    assert np.all((ratios >= -1e-12) & (ratios <= 1.0 + 1e-12))
    wanted = size * LINK / sqrt(3.0) * np.cos(angle - AXES)
    assert LINK * (ratios - np.mean(ratios)) == pytest.approx(wanted, abs=1e-9)


def clamped_degrees(kind: int, sense: float = 1.0) -> list[tuple[int, int, int]]:
    """List degree, leg and rail of each clamped leg over a turn of the voltage."""
    found = []
    for degree in range(360):
        ratios = ratios_of(kind, (degree + 0.5) * pi / 180.0, sense=sense)
        found += [
            (degree, leg, round(ratios[leg])) for leg in range(3) if min(ratios[leg], 1 - ratios[leg]) < 1e-9
        ]
    return found


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(
    ("kind", "upper", "lower"),
    [
        # Degrees of the first leg, whose voltage has its peaks at 0 and 180.
        (CONTINUOUS, (), ()),
        (DPWM_MIN, (), ((120, 240),)),
        (DPWM_MAX, ((-60, 60),), ()),
        (DPWM_0, ((-60, 0),), ((120, 180),)),
        (DPWM_1, ((-30, 30),), ((150, 210),)),
        (DPWM_2, ((0, 60),), ((180, 240),)),
        (DPWM_3, ((-60, -30), (30, 60)), ((120, 150), (210, 240))),
    ],
)
def test_a_leg_is_clamped_where_the_name_says(
    kind: int, upper: tuple[tuple[int, int], ...], lower: tuple[tuple[int, int], ...], sense: float
) -> None:
    clamped = clamped_degrees(kind, sense)
    for rail, sectors in ((1, upper), (0, lower)):
        expected = {degree % 360 for begin, end in sectors for degree in range(begin, end)}
        if sense < 0.0:
            # Turning backward, what comes ahead of a peak is on its other side.
            expected = {359 - degree for degree in expected}
        assert {degree for degree, leg, at in clamped if leg == 0 and at == rail} == expected
    assert len(clamped) == (0 if kind == CONTINUOUS else 360), "one leg at any time"


def farthest_flux(ratios: NDArray[np.float64], *, is_symmetric: bool) -> float:
    """Return how far the first phase's flux linkage is from its sample, over link voltage times carrier period.

    The carrier's period begins with the sample; there the upper switches are off, or with a sawtooth turn on.
    """
    begins, ends = (0.5 * (1.0 - ratios), 0.5 * (1.0 + ratios)) if is_symmetric else (0.0 * ratios, ratios)
    instants = np.unique(np.concatenate([[0.0, 1.0], begins, ends]))
    middles, lengths = 0.5 * (instants[1:] + instants[:-1]), np.diff(instants)
    excess = ((middles > begins[:, None]) & (middles < ends[:, None])) - ratios[:, None]
    voltages = (2.0 * excess[0] - excess[1] - excess[2]) / 3.0
    return float(np.max(np.abs(np.cumsum(voltages * lengths)), initial=0.0))


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("is_symmetric", "most"), [(True, 1.0 / 12.0), (False, 1.0 / 6.0)])
@pytest.mark.parametrize("kind", MODULATION_NUMBERS.values(), ids=MODULATION_NUMBERS)
@given(angle=st.floats(-pi, pi), size=st.floats(0.0, 1.0))
def test_no_phase_is_farther_from_its_sample_than_at_the_linear_limit_where_its_voltage_is_zero(
    kind: int, is_symmetric: bool, most: float, angle: float, size: float
) -> None:
    assert farthest_flux(ratios_of(kind, angle, size), is_symmetric=is_symmetric) <= most * (1.0 + 1e-9)
    worst = farthest_flux(ratios_of(kind, 0.5 * pi, 1.0), is_symmetric=is_symmetric)
    assert worst == pytest.approx(most, rel=1e-9)
