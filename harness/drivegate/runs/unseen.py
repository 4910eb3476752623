"""Records of runs that have not been made, from which follows whether a check looks at a run at all."""

from __future__ import annotations

from typing import Any

from drivegate.candidates.declaration import Declaration
from drivegate.runs.record import RunRecord
from drivegate.scenarios.windows import observed_windows
from drivegate_cases.scenario.scenario import Scenario


class NotRun(Exception):
    """Raised where something is read that only the run shows."""


class Unseen:
    """Stand-in for what a run shows: reading anything but what is already known raises `NotRun`."""

    def __init__(self, **known: Any) -> None:
        self.__dict__.update(known)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)


def unseen_record(declaration: Declaration, scenario: Scenario) -> RunRecord:
    """Make the record of a run that has not been made: its windows are known, but not what they show."""
    run: Any = Unseen(windows=tuple(Unseen() for _ in observed_windows(scenario)))
    return RunRecord(scenario, run, declaration)
