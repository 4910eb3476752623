"""Records of runs that have not been made."""

from __future__ import annotations

from typing import Any

from drivegate.candidates.declaration import Declaration
from drivegate.checks.unseen import Unseen
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.windows import observed_windows
from drivegate_cases.scenario.scenario import Scenario


def unseen_record(declaration: Declaration, scenario: Scenario) -> CurrentRecord:
    """Make the record of a run that has not been made: its windows are known, but not what they show."""
    run: Any = Unseen(windows=tuple(Unseen() for _ in observed_windows(scenario)))
    return CurrentRecord(scenario, run, declaration)
