"""Where a condition on a drive ceases to be met, by halving."""

from __future__ import annotations

from collections.abc import Callable


def last_met(is_met: Callable[[float], bool], met: float, missed: float, halvings: int) -> float:
    """Return the value nearest to where a condition ceases to be met that still meets it.

    `met` and `missed` are a value that meets it and one that does not, in either order.
    """
    for _ in range(halvings):
        middle = 0.5 * (met + missed)
        if is_met(middle):
            met = middle
        else:
            missed = middle
    return met
