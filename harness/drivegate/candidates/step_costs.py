"""What the steps of an emulated target cost there, whatever machine emulates it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class StepCosts(NamedTuple):
    """Costs of the most costly step, or what a manifest allows; 0 where nothing is counted or stated."""

    instructions: int = 0
    """Instructions of a step, those that a condition skips included."""
    cycles: int = 0
    """Estimated cycles of a step on a Cortex-M4, without wait states."""
    stack_bytes: int = 0
    """Depth of the stack."""


NO_COSTS = StepCosts()


def greatest_costs(costs: Iterable[StepCosts]) -> StepCosts:
    return StepCosts(*(max(each) for each in zip(NO_COSTS, *costs, strict=True)))
