"""A trip that the scenario gives a reason for is no lost torque; any other one is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import Run, judged, with_column, with_command

from drivegate.contracts.duty.likely_causes import likely_causes
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.right_trips import LOST_PERIODS
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.disturbance import Dropout
from drivegate_cases.scenario.scenario import Scenario

GONE_S = 0.01


def dipping(drive: PmAcDocument, share: float) -> Scenario:
    """Make a run whose link goes to a share of its voltage for a moment, and is back."""
    run, volts = torque_scenario(drive, 500.0, (1.0,)), drive.inverter.supply_voltage_v
    begin = run.duration_s
    profile = ((0.0, volts), (begin, volts), (begin, share * volts), (begin + GONE_S, share * volts))
    return run.replaced(duration_s=2.5 * begin, supply_v=(*profile, (begin + GONE_S, volts)))


def losing(drive: PmAcDocument, signal: str, periods: int) -> Scenario:
    """Make a run that loses a signal for some control periods."""
    run = torque_scenario(drive, 500.0, (1.0,))
    lost: Any = {"signal": signal, "start_s": run.duration_s, "duration_s": periods * run.control_period_s}
    return run.replaced(duration_s=2.5 * run.duration_s, dropouts=(Dropout(**lost),))


def tripped(record: DutyRecord, time_s: float) -> DutyRecord:
    """Make the record of a controller that turns its legs off, for good."""
    begin = round(time_s / record.scenario.control_period_s)
    later = np.arange(len(record.run.commands)) >= begin
    for leg in ("first_leg", "second_leg", "third_leg"):
        record = with_command(record, leg, lambda values: np.where(later, 0, values))
    record = with_command(record, "fault", lambda values: np.where(later, 3, values))
    return with_column(record, "torque", lambda values: np.where(later, 0.0, values))


@pytest.mark.parametrize("share", [0.4, 1.3])
def test_a_link_that_is_gone_or_far_too_high_is_a_reason_to_trip(
    interior: PmAcDocument, run: Run, share: float
) -> None:
    scenario = dipping(interior, share)
    begin = scenario.duration_s / 2.5
    record = run(scenario)
    assert len(record.steady) == 2
    right = tripped(record, begin + 2e-3)
    assert len(right.steady) == 1, "what follows is not judged"
    margin = judged("ACC-1", right)
    assert margin is not None
    assert margin.met, margin.measured
    early = judged("ACC-1", tripped(record, 0.9 * begin))
    assert early is not None
    assert not early.met, "nothing was wrong yet"


def test_a_link_that_dips_a_little_is_none(interior: PmAcDocument, run: Run) -> None:
    scenario = dipping(interior, 0.87)
    margin = judged("ACC-1", tripped(run(scenario), scenario.duration_s / 2.5 + 2e-3))
    assert margin is not None
    assert not margin.met
    assert "where the controller has turned all legs off, with the fault code 3" in margin.measured
    ((first, _), *_) = likely_causes([{"id": "ACC-1", "measured": margin.measured}])
    assert "'reads_enable'" in first.words, "or it waits for enable"


@pytest.mark.parametrize("signal", ["supply", "currents", "speed"])
def test_a_signal_that_is_lost_for_long_is_a_reason_and_a_lost_sample_is_none(
    interior: PmAcDocument, run: Run, signal: str
) -> None:
    for periods, is_right in ((1, False), (LOST_PERIODS, True)):
        scenario = losing(interior, signal, periods)
        record = tripped(run(scenario), scenario.duration_s / 2.5 + 1e-3)
        margin = judged("ROB-5", record)
        assert (margin is None or margin.met) is is_right


def test_a_shaft_that_is_held_beyond_overspeed_is_a_reason(interior: PmAcDocument, run: Run) -> None:
    beyond = 1.02 * interior.rating.overspeed_rpm
    scenario = torque_scenario(interior, 500.0, (1.0,))
    begin = scenario.duration_s
    profile = (
        (0.0, 500.0),
        (begin, 500.0),
        (begin, beyond),
        (begin + GONE_S, beyond),
        (begin + GONE_S, 500.0),
    )
    scenario = scenario.replaced(duration_s=2.5 * begin, speed_rpm=profile)
    assert len(tripped(run(scenario), begin + 2e-3).steady) == 1
