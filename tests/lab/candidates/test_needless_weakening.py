"""Needless weakening shows in the losses that a report states."""

from __future__ import annotations

from functools import cache

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.behaviour import behaviour
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.record import DutyRecord
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario


def drive_of(name: str) -> PmAcDocument:
    drive = load_drive(name).replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    return drive


@cache
def run(scenario: Scenario, candidate: str = "foc") -> DutyRecord:
    loaded = own_candidate(resolve_candidate(candidate))
    return duty_record(recorded(loaded, scenario, loaded.controller()))


def test_needless_weakening_shows_in_the_losses() -> None:
    drive = drive_of("pm-ac-interior")
    stated, other = (
        behaviour(lambda scenario, name=name: run(scenario, name), drive, None)["points"]
        for name in ("foc", "faulty:stuck-weakening")
    )
    assert stated[0]["above_least_percent"] < 1.0 < other[0]["above_least_percent"]
