"""How likely something is that happened in some of many runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

CONFIDENCE: Final = 0.95
"""Confidence of the intervals, unless another one is requested."""


@dataclass(frozen=True)
class Proportion:
    """How often something happened, and how likely it therefore is.

    Attributes
    ----------
    happened, runs : int
        In how many runs it did, of how many.
    estimate : float or None
        The share; None where there were no runs.
    low, high : float
        Clopper-Pearson interval of the probability.
    """

    happened: int
    runs: int
    estimate: float | None
    low: float
    high: float


def proportion(happened: int, runs: int, confidence: float = CONFIDENCE) -> Proportion:
    """Estimate a probability from a count."""
    from scipy.stats import binomtest

    if runs == 0:
        return Proportion(0, 0, None, 0.0, 1.0)
    interval = binomtest(happened, runs).proportion_ci(confidence, method="exact")
    return Proportion(happened, runs, happened / runs, float(interval.low), float(interval.high))
