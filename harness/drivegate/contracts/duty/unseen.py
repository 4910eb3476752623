"""Records of runs with duty ratios that have not been made."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from drivegate.candidates.declaration import Declaration
from drivegate.checks.unseen import NotRun, Unseen
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.dead_time import with_other_dead_time
from drivegate.contracts.duty.scenarios.windows import DutyDwell, duty_windows
from drivegate_cases.scenario.scenario import Scenario


class _UnseenWindow(DutyWindow):
    """Stretch in which a steady state would be judged: what it shows is not known."""

    def __init__(self, dwell: DutyDwell, start_s: float, end_s: float) -> None:
        self.__dict__.update(dwell=dwell, start_s=start_s, end_s=end_s)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)


class _UnseenDutyRecord(DutyRecord):
    """Record of a run that has not been made."""

    @cached_property
    def steady(self) -> tuple[DutyWindow, ...]:
        """The stretches in which a steady state would be judged."""
        return tuple(_UnseenWindow(*window) for window in duty_windows(self.scenario))


def unseen_duty_record(declaration: Declaration, scenario: Scenario) -> DutyRecord:
    """Make the record of a run that has not been made: its windows are known, but not what they show."""
    run: Any = Unseen()
    other = with_other_dead_time(scenario)
    compared = None if other is None else _UnseenDutyRecord(other, run, declaration)
    return _UnseenDutyRecord(scenario, run, declaration, other_dead_time=compared)
