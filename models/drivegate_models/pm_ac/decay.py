"""The share of a deviation that a lag of first order leaves after a time."""

from __future__ import annotations

from typing import Final

TERMS: Final = 24
"""Terms of the series: for arguments up to 1 the rest is below the rounding."""


def decay_of(share: float) -> float:
    """Return ``exp(-share)`` by its series, which every processor rounds the same way."""
    total = term = 1.0
    for order in range(1, TERMS):
        term *= -share / order
        total += term
    return total
