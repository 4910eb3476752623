"""Constants come back from figures that were made from them, and their uncertainty is what repeating shows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from drivegate_models.machine.constants_fit import ConstantsFit, fit_constants

TIMES = np.linspace(0.1, 3.0, 25)
TRUE = np.array([3e-3, 40.0])
NOISE = 1e-5


def decay(constants: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(constants[0] * np.exp(-constants[1] / 40.0 * TIMES))


def fitted(measured: NDArray[np.float64]) -> ConstantsFit:
    return fit_constants(lambda c: decay(c) - measured, [1e-3, 100.0], [1e-5, 1.0], [1.0, 1e3])


def test_constants_of_any_size_come_back() -> None:
    found = fitted(decay(TRUE))
    assert found.converged, found.message
    assert found.values == pytest.approx(TRUE, rel=1e-8)
    assert np.abs(found.residuals).max() < 1e-12


def test_derivatives_are_by_the_logarithms() -> None:
    found = fitted(decay(TRUE))
    assert found.derivatives[:, 0] == pytest.approx(decay(TRUE), rel=1e-3)


def test_the_uncertainty_is_what_repeating_the_measurement_shows() -> None:
    random = np.random.default_rng(1)
    repeated = np.array(
        [fitted(decay(TRUE) + NOISE * random.standard_normal(len(TIMES))).values for _ in range(200)]
    )
    stated = fitted(decay(TRUE)).relative_spread(NOISE**2)
    assert stated == pytest.approx(repeated.std(axis=0) / TRUE, rel=0.15)


def test_what_the_figures_do_not_state_has_no_end_of_uncertainty() -> None:
    found = fit_constants(lambda c: c[0] * TIMES - 2.0 * TIMES, [1.0, 5.0], [0.1, 0.1], [10.0, 10.0])
    spread = found.relative_spread(1.0)
    assert np.isfinite(spread[0])
    assert np.isinf(spread[1])
