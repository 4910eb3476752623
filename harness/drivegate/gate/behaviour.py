"""How a candidate behaves in plain runs of its drive, for the report: what the checks' numbers do not show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.running import recorded
from drivegate.gate.recording import shown_scenario
from drivegate.results.result import CheckOutcome
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

_OF_STEPS: Final = "STP-1"


@dataclass(frozen=True)
class BehaviourPlan:
    """What is to be run."""

    drive: DriveDocument
    """The drive."""
    step: dict[str, Any] | None
    """Scenario that shows how steps are followed, as plain data."""


def behaviour_job(
    drive: DriveDocument, declaration: Declaration, outcomes: Iterable[CheckOutcome]
) -> Job[dict[str, Any]] | None:
    """Plan the work; None where reports show nothing of the sort, or a candidate does not follow both references."""
    if contract_of(drive).behaviour is None or len(declaration.references) == 1:
        return None
    step = next((shown_scenario(outcome) for outcome in outcomes if outcome.id == _OF_STEPS), None)
    return Job(run_behaviour, BehaviourPlan(drive, step))


def run_behaviour(loaded: JudgedCandidate, plan: BehaviourPlan) -> dict[str, Any]:
    """Run a candidate and measure how it behaves; this is what the worker process does."""
    behaviour = contract_of(plan.drive).behaviour
    assert behaviour is not None, "only such a kind is planned for"
    step = None if plan.step is None else parse_document(plan.step, Scenario, "the scenario of steps")
    controller = loaded.controller()
    return behaviour(lambda scenario: recorded(loaded, scenario, controller), plan.drive, step)
