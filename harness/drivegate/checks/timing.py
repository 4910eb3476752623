"""Check of a step's compute time."""

from __future__ import annotations

from drivegate.checks.check import Check

TIMED_STEPS = 4000
"""Number of steps that are timed, in a run that has as many (1)."""
LARGEST_SHARE = 0.1
"""Greatest share of the control period that a step may take to compute (1)."""

TIM_1 = Check(
    id="TIM-1",
    requirement="A step's compute time stays below 10 % of the control period, on the machine that checks.",
    source="the contract",
    level="advisory",
    limit="10 % of the control period",
    scenarios="steps on the Senses of a recorded run, timed in blocks",
    formula="1 - median of the blocks' mean times of a step / control period / 10 %",
    why="A controller that is slow already here will not keep its period on a microcontroller.",
    volatile=True,
)
