"""How likely something is that happened in some of many runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

CONFIDENCE: Final = 0.95
"""Confidence of the intervals, unless another one is requested."""


@dataclass(frozen=True)
class Proportion:
    """How often something happened, and how likely it therefore is."""

    happened: int
    runs: int
    """In how many runs it did, of how many."""
    estimate: float | None
    """The share; None where there were no runs."""
    low: float
    high: float
    """Clopper-Pearson interval of the probability."""


def proportion(happened: int, runs: int, confidence: float = CONFIDENCE) -> Proportion:
    # The quantiles by themselves: scipy.stats takes a second to import.
    from scipy.special import betaincinv

    if runs == 0:
        return Proportion(0, 0, None, 0.0, 1.0)
    tail = 0.5 * (1.0 - confidence)
    low = betaincinv(happened, runs - happened + 1, tail) if happened else 0.0
    high = betaincinv(happened + 1, runs - happened, 1.0 - tail) if happened < runs else 1.0
    return Proportion(happened, runs, happened / runs, float(low), float(high))
