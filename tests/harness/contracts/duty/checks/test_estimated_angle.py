"""A candidate that estimates no angle is judged without SLS-3, and told so."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.checks.check import judged
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.sensorless import flying_start
from drivegate.results.verdict import check_outcomes
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

DRIVE = duty_document(load_drive("pm-ac-2kw-sensorless"))


def test_without_an_estimate_the_speed_alone_is_judged() -> None:
    run = flying_start(DRIVE, DRIVE.rating.base_speed_rpm)
    record = DUTY.record(prepared_duty_loop, NOTHING_DECLARED, run, DutyController(SENSORLESS))
    commands = record.run.commands.copy()
    commands["angle"] = nan
    unknown = replace(record, run=replace(record.run, commands=commands))
    verdicts = {}
    for each in (record, unknown):
        runs = [judged(each, contract_of(DRIVE).checks)]
        for outcome in check_outcomes(runs, NOTHING_DECLARED, DRIVE, complete=True):
            verdicts.setdefault(outcome.id, []).append(outcome)
    assert [outcome.verdict for outcome in verdicts["SLS-2"]] == ["pass", "pass"]
    known, without = verdicts["SLS-3"]
    assert known.verdict == "pass"
    assert without.verdict == "not applicable"
    assert "without one, SLS-2 alone judges these stretches" in without.message
