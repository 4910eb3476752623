"""What a run is judged as: the margins of every check, as a worker hands them back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin
from drivegate.checks.record import Record


@dataclass(frozen=True)
class JudgedRun:
    """A run's scenario and margins; what a worker hands back."""

    scenario: dict[str, Any]
    """The scenario as plain data."""
    margins: tuple[Margin, ...]
    """Of every check that applies."""
    digest: int = 0
    """Digest of the commands; 0 where they are not compared."""
    costs: StepCosts = NO_COSTS
    """Greatest costs of a step on an emulated target."""


@dataclass(frozen=True)
class InfeasibleScenario:
    """A drawn scenario on which no candidate may be judged; it was not run."""

    scenario: str
    """Its name."""
    reason: str
    """Why no controller could do what it requires."""


@dataclass(frozen=True)
class ShardOutcome:
    """What a job came to."""

    runs: tuple[JudgedRun, ...]
    """In the order in which they were made."""
    infeasible: tuple[InfeasibleScenario, ...] = ()
    """Drawn scenarios that no controller could do, which were not run."""


def judged(record: Record, checks: Iterable[Check]) -> JudgedRun:
    """Apply checks to a run."""
    margins = (check.evaluate(record) for check in checks)
    return JudgedRun(
        record.scenario.to_mapping(),
        tuple(margin for margin in margins if margin is not None),
        record.run.digest,
        record.costs,
    )
