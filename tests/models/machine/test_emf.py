"""Corners of a sine, rounded once from the exact value, which no library of a processor promises."""

from __future__ import annotations

from decimal import Decimal, localcontext

import pytest

from drivegate_models.machine.emf import sine_corners


def _exact_sine(angle: float) -> Decimal:
    x = Decimal(angle)
    total, term, order = x, x, 1
    while abs(term) > Decimal(10) ** -60:
        term = -term * x * x / ((order + 1) * (order + 2))
        total, order = total + term, order + 2
    return total


@pytest.mark.parametrize("pieces", [2, 90, 1000])
def test_every_corner_is_the_nearest_double(pieces: int) -> None:
    angles, values = sine_corners(pieces)
    assert values[0] == 0.0
    assert values[pieces // 2] == 1.0
    with localcontext() as context:
        context.prec = 80
        for angle, value in zip(angles.tolist(), values.tolist(), strict=True):
            exact = _exact_sine(angle)
            assert float(exact) == value, f"the sine of {angle!r} is {value!r}, exactly {float(exact)!r}"
