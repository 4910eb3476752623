"""A machine's constants from measured or published figures, by least squares, with their uncertainty."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

_TOLERANCE = 1e-13
_DIFFERENCE = 1e-4
_UNKNOWN = 1e-9


class ConstantsFit(NamedTuple):
    """Fitted constants with their residuals and their uncertainty."""

    values: NDArray[np.float64]
    """The constants, shape (n,), in their own units."""
    residuals: NDArray[np.float64]
    """Residual of each figure, shape (k,)."""
    derivatives: NDArray[np.float64]
    """Derivatives of the residuals by the logarithms of the constants, shape (k, n)."""
    converged: bool
    message: str
    """Reason for the end of the search."""

    def relative_spread(self, variance: float) -> NDArray[np.float64]:
        """Return the relative standard uncertainty of each constant, shape (n,).

        `variance`: variance of each figure, in the square of the residuals' unit. Result, shape (n,): roots of the
        diagonal of ``variance * inv(J.T @ J)``; infinite for constants that the figures do not determine.
        """
        _, singular, directions = np.linalg.svd(self.derivatives, full_matrices=False)
        known = singular > _UNKNOWN * singular[0]
        shares = directions * directions
        spread = variance * np.sum(shares[known] / singular[known, None] ** 2, axis=0)
        return np.where(np.sum(shares[~known], axis=0) > _UNKNOWN, np.inf, np.sqrt(spread))

    @property
    def condition(self) -> float:
        """Condition number of the derivatives: the ratio of the constants' uncertainties."""
        return float(np.linalg.cond(self.derivatives))


def fit_constants(
    residuals_of: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    start: ArrayLike,
    lowest: ArrayLike,
    highest: ArrayLike,
) -> ConstantsFit:
    """Fit constants to figures by least squares.

    `residuals_of`: function of the constants, shape (n,), that returns the residual of each figure, shape (k,), k >= n.
    `start`, shape (n,): initial values of the constants, above 0. `lowest`, `highest`, shape (n,): bounds of the
    constants. Result: the same for the same input.
    """
    # Henries and volt-seconds differ by orders of magnitude, which the trust region must not see.
    scale = np.asarray(start, dtype=np.float64)

    def of_shares(shares: NDArray[np.float64]) -> NDArray[np.float64]:
        return residuals_of(shares * scale)

    found = least_squares(
        of_shares,
        np.ones(len(scale)),
        bounds=(np.asarray(lowest) / scale, np.asarray(highest) / scale),
        diff_step=[_DIFFERENCE] * len(scale),
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_TOLERANCE,
    )
    # Relative changes, so that the condition number does not depend on units.
    return ConstantsFit(
        np.asarray(found.x * scale),
        np.asarray(found.fun),
        np.asarray(found.jac) * found.x,
        bool(found.success),
        str(found.message),
    )
