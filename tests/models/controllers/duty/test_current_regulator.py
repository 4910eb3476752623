"""What current regulators do at the voltage limit, and the ripple by which they compensate dead time."""

from __future__ import annotations

from math import hypot

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_models.controllers.duty.current_regulator import _limited_request, _ripple_at_edge

pytestmark = pytest.mark.kernel
LIMIT = 173.0


def test_decoupling_remains_where_the_currents_only_move_a_little_more_slowly() -> None:
    direct, quadrature = _limited_request((-30.0, 104.0), (0.0, 100.0), (27.0, 0.0), LIMIT)
    assert direct == pytest.approx(-3.0)
    assert hypot(direct, quadrature) == pytest.approx(LIMIT)


def test_the_currents_move_before_they_are_decoupled_where_the_limit_leaves_too_little() -> None:
    # Whole decoupling would leave 4 V of 60 V.
    direct, quadrature = _limited_request((0.0, 130.0), (0.0, 60.0), (110.0, 0.0), LIMIT)
    assert direct == pytest.approx(0.0, abs=1e-9)
    assert quadrature == pytest.approx(LIMIT)


@given(st.tuples(*(st.integers(0, 1000) for _ in range(3))))
def test_the_ripple_at_an_edge_is_the_integral_of_the_switched_voltages(duties: tuple[int, int, int]) -> None:
    # In thousandths of half a carrier period, each leg is low up to its edge and high from there on.
    steps = np.arange(1000)
    legs = np.array([steps >= 1000 - duty for duty in duties], dtype=float)
    ratios = np.array(duties) / 1000.0
    switched = legs - legs.mean(axis=0)
    mean = (ratios - ratios.mean())[:, None]
    first_edge = 1000 - duties[0]
    ripple = float((switched - mean)[0, :first_edge].sum()) / 1000.0
    assert _ripple_at_edge(*(float(ratio) for ratio in ratios)) == pytest.approx(ripple, abs=1e-12)
