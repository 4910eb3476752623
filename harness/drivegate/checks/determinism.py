"""Check of determinism: the same scenario gives the same commands."""

from __future__ import annotations

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin
from drivegate.checks.record import Record


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
    source="the contract",
    level="required",
    limit="bit for bit",
    scenarios="repeated runs: after another scenario on the same instance, on a new instance, and in another process",
    formula="1 when all commands of every repetition are the same, else -1",
    why="A verdict holds, and a counterexample can be replayed, only where the same inputs give the same outputs.",
    evaluate=repeats_itself,
)
