"""Which runs some checks need: those that one of them looks at before it passes a scenario over."""

from __future__ import annotations

from collections.abc import Collection

from drivegate.candidates.declaration import Declaration
from drivegate.checks.unseen import NotRun
from drivegate.contracts.catalogue import contract_of
from drivegate_cases.scenario.scenario import Scenario


def is_needed(scenario: Scenario, declaration: Declaration, only: Collection[str]) -> bool:
    """Return True if one of some checks may judge a run of a scenario; no names mean all checks.

    Each check is evaluated without a run. One that returns no margin without a look at the run returns none after it.
    """
    if not only:
        return True
    contract = contract_of(scenario.drive)
    record = contract.unseen(declaration, scenario)
    try:
        return any(check.evaluate(record) is not None for check in contract.checks() if check.id in only)
    except NotRun:
        return True
