"""Checks of every contract: determinism, and the cost of a step, in time or on an emulated target."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from drivegate.candidates.step_costs import StepCosts
from drivegate.checks.check import Check, Record
from drivegate.checks.margin import Margin, at_most, worst_required

TIMED_STEPS = 4000
"""Number of steps that are timed, in a run that has as many (1)."""
LARGEST_SHARE = 0.1
"""Greatest share of the control period that a step may take to compute (1)."""
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
        Margin("TIM-1", at_most(cost, limit), f"{words.format(cost)} a step, {limit} stated in '{key}'")
        for (words, key), cost, limit in zip(_COSTS, costs, limits, strict=True)
        if cost and limit
    ]
    return worst_required(stated)


def margin_on_target(record: Record) -> Margin | None:
    return counted_margin(record.costs, record.allowed_costs)


TIM_1 = Check(
    id="TIM-1",
    requirement="A step's compute time stays below 10 % of the control period, on the machine that checks.",
    level="advisory",
    limit="10 % of the control period",
    scenarios="steps on the Senses of a recorded run, timed in blocks",
    formula="1 - median of the blocks' mean times of a step / control period / 10 %",
    why="A controller that is slow already here will not keep its period on a microcontroller.",
    evaluate=margin_on_target,
    volatile=True,
)


def on_target(check: Check) -> Check:
    """Return the check as it judges what steps cost on an emulated target."""
    return replace(
        check,
        requirement="A step costs at most what the manifest states, on the emulated target.",
        limit="what the manifest states",
        scenarios="every step of every run",
    )


def repeats_itself(record: Record) -> Margin | None:
    """Judge whether further runs of the scenario gave the same commands, bit for bit."""
    if not record.repeated_digests:
        return None
    different = sum(digest != record.run.digest for digest in record.repeated_digests)
    if different == 0:
        return Margin("DET-1", 1.0, f"{len(record.repeated_digests)} repetitions are the same")
    counted = f"{different} of {len(record.repeated_digests)} repetitions differ"
    return Margin("DET-1", -1.0, record.parting or counted)


DET_1 = Check(
    id="DET-1",
    requirement="The same scenario twice gives the same outputs, and reset forgets everything.",
    limit="bit for bit",
    scenarios="repeated runs: after another scenario on the same instance, on a new instance, and in another process",
    formula="1 when all commands of every repetition are the same, else -1",
    why="A verdict holds, and a counterexample can be replayed, only where the same inputs give the same outputs.",
    evaluate=repeats_itself,
)
