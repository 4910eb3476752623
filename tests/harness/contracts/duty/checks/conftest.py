"""Runs of the field-oriented controller on the interior machine, each made once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.record import DutyRecord
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

Run = Callable[[Scenario], DutyRecord]
CHECKS = {check.id: check for check in contract_named("duty").checks}


@pytest.fixture(scope="session")
def interior() -> PmAcDocument:
    drive = load_drive("pm-ac-interior")
    assert isinstance(drive, PmAcDocument)
    # Half of the usual time, in which the plain runs settle all the same.
    return drive.replaced(settling_s=0.4)


@pytest.fixture(scope="session")
def run() -> Run:
    loaded = own_candidate(resolve_candidate("foc"))
    controller = loaded.controller()

    @cache
    def made(scenario: Scenario) -> DutyRecord:
        record = recorded(loaded, scenario, controller)
        assert isinstance(record, DutyRecord)
        return record

    return made


def with_column(record: DutyRecord, name: str, change: Callable[[Any], Any]) -> DutyRecord:
    """Make the record of a run in which one signal was another."""
    trace = record.run.trace.copy()
    place = record.run.columns.index(name)
    trace[:, place] = change(trace[:, place])
    return replace(record, run=replace(record.run, trace=trace))


def with_command(record: DutyRecord, name: str, change: Callable[[Any], Any]) -> DutyRecord:
    """Make the record of a run in which one part of the answers was another."""
    commands = record.run.commands.copy()
    commands[name] = change(np.array(commands[name]))
    return replace(record, run=replace(record.run, commands=commands))


def judged(check: str, record: DutyRecord) -> Margin | None:
    """Apply a check."""
    return CHECKS[check].evaluate(record)
