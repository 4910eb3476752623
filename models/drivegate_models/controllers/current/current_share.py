"""How much current flows, as a share of the most that can."""

from __future__ import annotations

from typing import Any

from drivegate_models.compilation.kernels import inlined


@inlined
def greatest_current_sum(state: Any) -> float:
    """Return the current sum with every conducting phase at the limit.

    Returns
    -------
    float
        Current sum (A).
    """
    full: float = state.conducting_phases * state.current_limit
    return full


@inlined
def draws_less_than(state: Any, share: float) -> bool:
    """Return whether less than a share of the greatest current sum has flown in the last decision interval.

    Parameters
    ----------
    share : float
        Of the greatest current sum (1).

    Returns
    -------
    bool
        About its mean current sum.
    """
    less: bool = state.last_power < share * greatest_current_sum(state)
    return less
