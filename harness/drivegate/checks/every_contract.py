"""Checks of every contract: determinism, and the compute time of a step."""

from __future__ import annotations

from drivegate.checks.check import Check, Record
from drivegate.checks.margin import Margin
from drivegate.checks.target_costs import margin_on_target

TIMED_STEPS = 4000
"""Number of steps that are timed, in a run that has as many (1)."""
LARGEST_SHARE = 0.1
"""Greatest share of the control period that a step may take to compute (1)."""

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
