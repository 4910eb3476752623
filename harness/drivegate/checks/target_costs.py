"""What steps cost on an emulated target, judged by what the manifest allows."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from drivegate.candidates.step_costs import StepCosts
from drivegate.checks.check import Check, Record
from drivegate.checks.margin import Margin, at_most, worst_required

_ID: Final = "TIM-1"
_COSTS: Final = (
    ("{} instructions", "step_instructions"),
    ("about {} cycles", "step_cycles"),
    ("{} bytes of stack", "stack_bytes"),
)
"""How each cost is written, and the key of a manifest that limits it."""


def costs_in_words(costs: StepCosts) -> str:
    """Write the costs that are known; empty for none."""
    return ", ".join(words.format(cost) for (words, _), cost in zip(_COSTS, costs, strict=True) if cost)


def counted_margin(costs: StepCosts, limits: StepCosts) -> Margin | None:
    """Judge what steps cost on their target; None without a limit or a cost."""
    stated = [
        Margin(_ID, at_most(cost, limit), f"{words.format(cost)} a step, {limit} stated in '{key}'")
        for (words, key), cost, limit in zip(_COSTS, costs, limits, strict=True)
        if cost and limit
    ]
    return worst_required(stated)


def margin_on_target(record: Record) -> Margin | None:
    """Judge what the steps of a run cost on their target."""
    return counted_margin(record.costs, record.allowed_costs)


def on_target(check: Check) -> Check:
    """Return the check as it judges what steps cost on an emulated target."""
    return replace(
        check,
        requirement="A step costs at most what the manifest states, on the emulated target.",
        limit="what the manifest states",
        scenarios="every step of every run",
    )
