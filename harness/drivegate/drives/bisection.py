"""Where a condition on a drive ceases to be met, by halving."""

from __future__ import annotations

from collections.abc import Callable


def last_met(is_met: Callable[[float], bool], met: float, missed: float, halvings: int) -> float:
    """Find the value nearest to where a condition ceases to be met that still meets it.

    Parameters
    ----------
    is_met : callable
        Tells of a value whether it meets the condition.
    met, missed : float
        A value that does and one that does not, in either order.
    halvings : int
        How often the way between them is halved.

    Returns
    -------
    float
        The value found, which meets the condition.
    """
    for _ in range(halvings):
        middle = 0.5 * (met + missed)
        if is_met(middle):
            met = middle
        else:
            missed = middle
    return met
