"""A machine's constants from measured or published figures, by least squares, with how firmly they follow."""

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
    """Fitted constants, and how well and how firmly they follow from the figures."""

    values: NDArray[np.float64]
    """The constants, shape (n,), in their own units."""
    residuals: NDArray[np.float64]
    """What is left of each figure, shape (k,)."""
    derivatives: NDArray[np.float64]
    """Derivatives of the residuals by the logarithms of the constants, shape (k, n)."""
    converged: bool
    """Whether the search has come to rest."""
    message: str
    """Why it ended."""

    def relative_spread(self, variance: float) -> NDArray[np.float64]:
        """Return the standard uncertainty of each constant over the constant itself, shape (n,).

        Parameters
        ----------
        variance : float
            Variance of each figure, in the square of the residuals' unit.

        Returns
        -------
        ndarray, shape (n,)
            Roots of the diagonal of ``variance * inv(J.T @ J)``; infinite where the figures do not tell.
        """
        _, singular, directions = np.linalg.svd(self.derivatives, full_matrices=False)
        known = singular > _UNKNOWN * singular[0]
        shares = directions * directions
        spread = variance * np.sum(shares[known] / singular[known, None] ** 2, axis=0)
        return np.where(np.sum(shares[~known], axis=0) > _UNKNOWN, np.inf, np.sqrt(spread))

    @property
    def condition(self) -> float:
        """Condition number of the derivatives: how differently firm the constants are."""
        return float(np.linalg.cond(self.derivatives))


def fit_constants(
    residuals_of: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    start: ArrayLike,
    lowest: ArrayLike,
    highest: ArrayLike,
) -> ConstantsFit:
    """Fit constants to figures.

    Parameters
    ----------
    residuals_of : callable
        From constants, shape (n,), to what is left of each figure, shape (k,) with k of n or more.
    start : array_like, shape (n,)
        Constants to begin with, above 0.
    lowest, highest : array_like, shape (n,)
        Bounds of the constants.

    Returns
    -------
    ConstantsFit
        The constants of least squares; the same for the same input.
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
