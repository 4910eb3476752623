"""Motion of the shaft within a control period, against the closed form of each piece."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drivegate_models.compilation.kernels import kernel
from drivegate_models.loop.shaft import Motion, motion_of

pytestmark = pytest.mark.kernel
PERIOD = 1e-4
INERTIA = 1e-6


@kernel
def _move(driving, opposing, damping, inertia, speed, length):
    return motion_of(driving, opposing, damping, inertia, speed, length)


def moved(
    driving: float, opposing: float, speed: float, damping: float = 0.0, length: float = PERIOD
) -> Motion:
    return Motion(*_move(driving, opposing, damping, INERTIA, speed, length))


def exact(driving: float, opposing: float, speed: float, length: float) -> float:
    """Return the final speed of a shaft with constant torques, piece by piece."""
    sense = np.sign(speed) or np.sign(driving)
    rate = (driving - sense * opposing) / INERTIA
    rest = -speed / rate if rate * speed < 0.0 else np.inf
    if speed != 0.0 and rest >= length:
        return speed + rate * length
    if abs(driving) <= opposing:
        return 0.0
    left = length - (rest if speed != 0.0 else 0.0)
    return float((driving - np.sign(driving) * opposing) / INERTIA * left)


@given(driving=st.floats(-0.1, 0.1), opposing=st.floats(0.0, 0.05), speed=st.floats(-5.0, 5.0))
@settings(max_examples=300, deadline=None, derandomize=True, database=None)
def test_a_shaft_that_comes_to_rest_within_the_period_goes_on_as_its_torques_say(
    driving: float, opposing: float, speed: float
) -> None:
    motion = moved(driving, opposing, speed)
    assert speed + motion.gained == pytest.approx(
        exact(driving, opposing, speed, PERIOD), rel=1e-9, abs=1e-12
    )
    mirror = moved(-driving, opposing, -speed)
    assert (mirror.gained, mirror.trend, mirror.share) == (-motion.gained, -motion.trend, motion.share)


def test_a_brake_that_the_machine_reverses_leaves_no_error_of_first_order() -> None:
    """Without the split, the brake would go on driving the shaft through standstill: 1 rad/s too much here."""
    motion = moved(-0.02, 0.01, 1.5)
    assert 1.5 + motion.gained == pytest.approx(-0.5, abs=1e-12)
    assert (motion.trend, motion.share) == (pytest.approx(-1.0), pytest.approx(0.5))


def test_a_brake_holds_what_it_has_stopped() -> None:
    motion = moved(-0.02, 0.03, 1.5)
    assert (motion.gained, motion.trend) == (-1.5, 0.0)
    assert moved(-0.02, 0.03, 0.0) == Motion(0.0, 0.0, 1.0)


@pytest.mark.parametrize("speed", [2.0, 0.5, -0.3])
def test_viscous_friction_is_second_order(speed: float) -> None:
    damping, driving, opposing, duration = 5e-3, -4e-3, 1e-3, 1e-3

    def rate(_time: float, state: np.ndarray) -> np.ndarray:
        return np.array([(driving - np.sign(state[0]) * opposing - damping * state[0]) / INERTIA])

    def rests(_time: float, state: np.ndarray) -> float:
        return float(state[0])

    # scipy reads this from the function itself, which has no such attribute for a type checker.
    rests.terminal = True  # type: ignore[attr-defined]
    first = solve_ivp(rate, (0.0, duration), [speed], rtol=1e-12, atol=1e-14, events=rests)
    final, time = float(first.y[0, -1]), float(first.t[-1])
    if first.status == 1:
        second = solve_ivp(rate, (time, duration), [-1e-15], rtol=1e-12, atol=1e-14)
        final = float(second.y[0, -1])
    errors = []
    for periods in (8, 16, 32):
        now = speed
        for _ in range(periods):
            now += moved(driving, opposing, now, damping, duration / periods).gained
        errors.append(abs(now - final))
    assert errors[2] < errors[1] / 3.0 < errors[0] / 9.0, errors
