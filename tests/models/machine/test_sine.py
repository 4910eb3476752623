"""Sine and cosine agree with the library to rounding, in every quarter and beyond a turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivegate_models.machine.sine import cosine_sine, small_cosine_sine


@pytest.mark.kernel
def test_every_quarter_agrees_with_the_library() -> None:
    for angle in np.linspace(-40.0, 40.0, 2001):
        cosine, sine = cosine_sine(angle)
        assert cosine == pytest.approx(math.cos(angle), abs=3e-16), f"cosine of {angle}"
        assert sine == pytest.approx(math.sin(angle), abs=3e-16), f"sine of {angle}"


@pytest.mark.kernel
def test_small_angles_keep_their_digits() -> None:
    for angle in [*np.linspace(-math.pi / 4, math.pi / 4, 501), 1e-9, -1e-300, 0.0]:
        cosine, sine = small_cosine_sine(angle)
        assert cosine == pytest.approx(math.cos(angle), rel=2.3e-16)
        assert sine == pytest.approx(math.sin(angle), rel=2.3e-16, abs=0.0)
