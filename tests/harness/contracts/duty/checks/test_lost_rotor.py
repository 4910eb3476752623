"""A rotor that an overload stops: the run is fair, nothing but the loss is judged in it, and it has to be reported."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.duty.checks.sensorless.lost import lost_rotor
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.overload import OVERLOAD, greatest_at_rest, overloaded_s
from drivegate.contracts.duty.scenarios.sensorless import least_rpm, overloaded
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate.scenarios.rotation import mirrored
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

DRIVE = duty_document(load_drive("pm-ac-2kw-sensorless"))
RUN = overloaded(DRIVE, least_rpm(DRIVE, 2.0))
BEGIN, WHOLE = overloaded_s(RUN)


@pytest.fixture(scope="module")
def record() -> DutyRecord:
    return DUTY.record(prepared_duty_loop, NOTHING_DECLARED, RUN, DutyController(SENSORLESS))


def with_commands(record: DutyRecord, **columns: int) -> DutyRecord:
    commands = record.run.commands.copy()
    for name, value in columns.items():
        commands[name] = value
    return replace(record, run=replace(record.run, commands=commands))


def test_the_torque_is_out_of_reach_and_the_run_is_fair() -> None:
    greatest = greatest_at_rest(DRIVE.plant(), DRIVE.inverter.link_voltage_v)
    assert RUN.load.torque_at(0.0, 1.0) == pytest.approx(OVERLOAD * greatest, rel=1e-3)
    for run in (RUN, mirrored(RUN)):
        assert unfair_because(run) is None
        assert all(end <= BEGIN for _, _, end in duty_windows(run)), "no speed is judged under the overload"


def test_a_smaller_load_or_a_drive_with_a_sensor_is_not_overloaded() -> None:
    assert isinstance(RUN.load, ConstantTorqueLoad)
    lighter = RUN.replaced(load=RUN.load.model_copy(update={"torque_nm": 0.9 * RUN.load.torque_nm}))
    for run in (lighter, RUN.replaced(drive=load_drive("pm-ac-2kw"))):
        assert overloaded_s(run) == (inf, inf)
        assert "no currents within the limits give the torque" in str(unfair_because(run))


def test_the_controller_reports_it(record: DutyRecord) -> None:
    stopped = np.flatnonzero(np.abs(record.run.column("speed")) > 0.1)[-1] * RUN.control_period_s
    assert BEGIN < stopped < WHOLE + 0.5
    margin = lost_rotor(record)
    assert margin is not None
    assert margin.met, margin
    assert "N·m at a lost rotor" in margin.measured, "the torque is nearer to its limit than the time"


def test_what_is_not_reported_fails(record: DutyRecord) -> None:
    margin = lost_rotor(with_commands(record, fault=0))
    assert margin is not None
    assert not margin.met
    assert margin.measured.startswith("not reported 1")
    assert "after the overload stops the shaft at" in margin.measured


def test_legs_that_stay_on_are_no_safe_state(record: DutyRecord) -> None:
    margin = lost_rotor(with_commands(record, first_leg=LEG_PWM))
    assert margin is not None
    assert not margin.met
