"""What current regulators do at the voltage limit."""

from __future__ import annotations

from math import hypot

import pytest

from drivegate_models.controllers.duty.current_regulator import _limited_request

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
