"""Means that every processor finds the same."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def exact_mean(values: NDArray[np.float64]) -> float:
    """Return a mean whose sum is exact, so that no processor's way of adding shows in it."""
    return math.fsum(values.tolist()) / len(values)
