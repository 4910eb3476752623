"""The logarithm near one against decimal arithmetic of a hundred digits."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from drivegate_models.machine.winding_current import GREATEST, logarithm_ratio


def _error_in_last_place(x: float) -> float:
    with localcontext() as context:
        context.prec = 100
        exact = (1 + Decimal(x)).ln() / Decimal(x)
        found: float = logarithm_ratio(x)
        return float((Decimal(found) - exact) / Decimal(math.ulp(float(exact))))


@pytest.mark.kernel
@example(GREATEST)
@example(1e-30)
@given(st.floats(1e-30, GREATEST))
def test_the_logarithm_is_right_to_the_last_place(x: float) -> None:
    error = _error_in_last_place(x)
    assert abs(error) <= 1.0, f"ln(1 + {x!r}) / {x!r} is off by {error:.2f} units in the last place"


@pytest.mark.kernel
def test_it_is_right_over_the_whole_range_and_one_at_zero() -> None:
    assert logarithm_ratio(0.0) == 1.0
    worst = max(abs(_error_in_last_place(float(x))) for x in np.linspace(1e-6, GREATEST, 2000))
    assert worst <= 1.0, f"off by up to {worst:.2f} units in the last place"
