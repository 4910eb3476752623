"""Check of a step's compute time."""

from __future__ import annotations

from drivegate.checks.check import Check

LARGEST_SHARE = 0.1
"""Greatest share of the control period that a step may take to compute (1)."""

TIM_1 = Check(
    "TIM-1",
    "A step's compute time stays below 10 % of the control period, on the machine that checks.",
    "the contract",
    "candidate",
    "advisory",
    "10 % of the control period",
    "steps on the Senses of a recorded run, timed in blocks",
    "1 - median of the blocks' mean times of a step / control period / 10 %",
    "A controller that is slow already here will not keep its period on a microcontroller.",
    volatile=True,
)
