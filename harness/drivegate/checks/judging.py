"""What a run is judged as: the margins of every check, as a worker hands them back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin
from drivegate.checks.record import Record


@dataclass(frozen=True)
class JudgedRun:
    """A run's scenario and margins; what a worker hands back.

    Attributes
    ----------
    scenario : dict
        The scenario as plain data.
    margins : tuple of Margin
        Of every check that applies.
    digest : int
        Digest of the commands; 0 where they are not compared.
    """

    scenario: dict[str, Any]
    margins: tuple[Margin, ...]
    digest: int = 0


@dataclass(frozen=True)
class InfeasibleScenario:
    """A drawn scenario on which no candidate may be judged; it was not run.

    Attributes
    ----------
    scenario : str
        Its name.
    reason : str
        Why no controller could do what it requires.
    """

    scenario: str
    reason: str


@dataclass(frozen=True)
class ShardOutcome:
    """What a job came to.

    Attributes
    ----------
    runs : tuple of JudgedRun
        In the order in which they were made.
    infeasible : tuple of InfeasibleScenario
        Drawn scenarios that no controller could do, which were not run.
    """

    runs: tuple[JudgedRun, ...]
    infeasible: tuple[InfeasibleScenario, ...] = ()


def judged(record: Record, checks: Iterable[Check]) -> JudgedRun:
    """Apply checks to a run."""
    margins = (check.evaluate(record) for check in checks)
    return JudgedRun(
        record.scenario.to_mapping(),
        tuple(margin for margin in margins if margin is not None),
        record.run.digest,
    )
