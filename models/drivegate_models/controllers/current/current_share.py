"""Current sums compared with the maximum, which flows with every conducting phase at the limit."""

from __future__ import annotations

from typing import Any

from drivegate_models.compilation.kernels import inlined


@inlined
def maximum_current_sum(state: Any) -> float:
    """Return the current sum (A) with every conducting phase at the current limit."""
    maximum: float = state.conducting_phases * state.current_limit
    return maximum


@inlined
def is_current_below(state: Any, share: float) -> bool:
    """Return True if the last interval's mean current sum is below `share` (1) of the maximum."""
    below: bool = state.last_power < share * maximum_current_sum(state)
    return below
