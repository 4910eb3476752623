"""The closed forms of the winding current against arithmetic of 120 digits."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from drivegate_models.machine.winding_current import (
    LONGEST,
    crossing_time,
    current_after,
    current_integrals,
    phi4,
    turning_time,
)

ROUNDING = 4e-15
"""Greatest error, relative to the sum of the magnitudes of what is added up."""

exact_settings = settings(
    max_examples=300,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
starts = st.one_of(st.just(0.0), st.floats(1e-9, 30.0), st.floats(-30.0, -1e-9))
slopes = st.one_of(st.just(0.0), st.floats(1e-9, 4e4), st.floats(-4e4, -1e-9))
curvatures = st.one_of(st.just(0.0), st.floats(1e-9, 2e7), st.floats(-2e7, -1e-9))
rates = st.one_of(st.just(0.0), st.floats(1e-6, 1e3))
shares = st.one_of(st.floats(1e-6, 1.0), st.just(1.0))


def _exact(
    start: float, slope: float, curvature: float, rate: float, time: float
) -> tuple[Decimal, Decimal, Decimal, Decimal, Decimal]:
    """Return current, slope, integral, double integral and integral of the square from the exponential."""
    i0, g0, a, r, t = (Decimal(number) for number in (start, slope, curvature, rate, time))
    if r == 0:
        c, b, q = i0, g0, -a / 2
        square = (
            c * c * t + c * b * t**2 + (b * b + 2 * c * q) * t**3 / 3 + b * q * t**4 / 2 + q * q * t**5 / 5
        )
        return (
            c + b * t + q * t * t,
            b + 2 * q * t,
            c * t + b * t**2 / 2 + q * t**3 / 3,
            c * t**2 / 2 + b * t**3 / 6 + q * t**4 / 12,
            square,
        )
    # i = c + b t + w exp(-r t)
    w, b = -(g0 * r + a) / (r * r), -a / r
    c, decay = i0 - w, (-r * t).exp()
    fade = (1 - decay) / r
    slowed = (1 - decay * (1 + r * t)) / (r * r)
    square = (
        c * c * t
        + c * b * t**2
        + b * b * t**3 / 3
        + 2 * c * w * fade
        + 2 * b * w * slowed
        + w * w * (1 - decay * decay) / (2 * r)
    )
    return (
        c + b * t + w * decay,
        b - r * w * decay,
        c * t + b * t**2 / 2 + w * fade,
        c * t**2 / 2 + b * t**3 / 6 + w * (t - fade) / r,
        square,
    )


def _interval(rate: float, share: float) -> float:
    """Return a share of the longest interval that callers may request."""
    return share * (min(LONGEST / rate, 1e-2) if rate > 0.0 else 1e-2)


@pytest.mark.kernel
@pytest.mark.parametrize(
    "x", [0.0, 1e-12, 1e-4, 1.0 / 64.0, math.nextafter(1.0 / 64.0, 1.0), 0.02, 0.1, 0.25, 0.4, 0.5]
)
def test_phi4(x: float) -> None:
    exact: Decimal = sum(((-Decimal(x)) ** n / math.factorial(n + 4) for n in range(1, 60)), Decimal(1) / 24)
    assert abs(Decimal(phi4(x)) / exact - 1) < Decimal(ROUNDING)


@pytest.mark.kernel
@exact_settings
@given(starts, slopes, curvatures, rates, shares)
def test_current_and_integrals(
    start: float, slope: float, curvature: float, rate: float, share: float
) -> None:
    time = _interval(rate, share)
    with localcontext() as context:
        context.prec = 120
        exact = _exact(start, slope, curvature, rate, time)
    level = abs(start) + abs(slope) * time + abs(curvature) * time * time
    speed = abs(slope) + abs(curvature) * time
    scales = (level, speed, level * time, level * time * time, level * level * time)
    values = current_integrals(start, slope, curvature, rate, time)
    for name, value, expected, scale in zip(
        ("current", "slope", "integral", "double integral", "square"), values, exact, scales, strict=True
    ):
        error = abs(float(Decimal(value) - expected))
        assert error <= ROUNDING * scale, f"the {name} is {value!r}, exactly {float(expected)!r}"
    current, current_slope = current_after(start, slope, curvature, rate, time)
    assert abs(current - values[0]) <= ROUNDING * level, "both ways to the end current must agree"
    assert abs(current_slope - values[1]) <= ROUNDING * speed, "both ways to the end slope must agree"


@pytest.mark.kernel
@exact_settings
@given(slopes, curvatures, rates)
def test_turning_time(slope: float, curvature: float, rate: float) -> None:
    time = turning_time(slope, curvature, rate)
    if slope == 0.0 or curvature == 0.0 or (slope > 0.0) != (curvature > 0.0):
        assert time == math.inf, "a slope that only grows in magnitude has no zero"
        return
    assert time > 0.0
    if time < 1e-2 and rate * time <= LONGEST:
        remaining = current_after(0.0, slope, curvature, rate, time)[1]
        assert abs(remaining) <= 1e-9 * abs(slope) + ROUNDING * abs(curvature) * time, (
            f"the slope is still {remaining!r}"
        )


@pytest.mark.kernel
@exact_settings
@example(0.0, 0.0, -19999999.0, 0.0, 1.0, 15.0, True)
@given(
    starts, slopes, curvatures, rates, shares, st.one_of(st.just(0.0), st.floats(1e-9, 20.0)), st.booleans()
)
def test_first_crossing(
    start: float, slope: float, curvature: float, rate: float, share: float, gap: float, rising: bool
) -> None:
    """The current is on the level when it is said to be, and on the near side of it until then."""
    end = _interval(rate, share)
    sign = 1.0 if rising else -1.0
    level = start + sign * gap
    end_current, end_slope = current_after(start, slope, curvature, rate, end)
    found = crossing_time(start, slope, curvature, rate, end, end_current, end_slope, level, rising)
    scale = abs(start) + abs(level) + abs(slope) * end + abs(curvature) * end * end
    until = end
    if found <= end:
        assert found >= 0.0
        at_crossing = current_after(start, slope, curvature, rate, found)[0]
        assert abs(at_crossing - level) <= 1e-14 * scale, f"the current is {at_crossing!r}, not {level!r}"
        until = found
    for k in range(101):
        value = current_after(start, slope, curvature, rate, until * k / 100)[0]
        assert sign * (value - level) <= 1e-14 * scale, (
            f"the current is beyond the level at {k} % of the time to the crossing"
        )
