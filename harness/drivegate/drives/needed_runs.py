"""Which runs some checks need: those that one of them looks at before it passes a scenario over."""

from __future__ import annotations

from collections.abc import Collection

from drivegate.candidates.declaration import Declaration
from drivegate.drives.kinds import kind_of
from drivegate.runs.unseen import NotRun, unseen_record
from drivegate_cases.scenario.scenario import Scenario


def is_needed(scenario: Scenario, declaration: Declaration, only: Collection[str]) -> bool:
    """Return True if one of some checks may judge a run of a scenario; no names mean all checks.

    Each check is evaluated without a run. One that returns no margin without a look at the run returns none after it.
    """
    if not only:
        return True
    kind = kind_of(scenario.drive)
    record = (kind.unseen or unseen_record)(declaration, scenario)
    try:
        return any(check.evaluate(record) is not None for check in kind.checks() if check.id in only)
    except NotRun:
        return True
