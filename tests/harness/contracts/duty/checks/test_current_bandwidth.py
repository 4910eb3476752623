"""The current bandwidth that a candidate declares decides how long its steps of the torque may take."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import CHECKS

from drivegate.candidates.builtin.duty_loading import DutyController
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import on_drive
from drivegate.contracts.duty.checks.steps import (
    step_responses,
    straight_time_s,
    torque_steps,
    voltage_time_s,
)
from drivegate.contracts.duty.current_bandwidth import declared_rise_s, limited_rise_s, transient_periods
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.witnesses import Accusation, Defence, hear_witnesses
from drivegate.results.verdict import check_outcomes
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError

USUAL = 1000.0
"""Bandwidth that firmware has by default (rad/s): also stated as a time constant of 1 ms."""


def regulating(bandwidth: float) -> DutyController:
    """Make a controller whose current loops are of first order with a bandwidth (rad/s)."""

    class Regulating(DutyController):
        def reset(self, nameplate: Any) -> None:
            super().reset(nameplate)
            state = self._state
            period = state["lead"] / 1.5
            for axis in ("direct", "quadrature"):
                state[f"{axis}_gain"] = bandwidth * state[f"{axis}_inductance"]
                state[f"{axis}_integral_step"] = bandwidth * state["resistance"] * period

    return Regulating()


@cache
def steps(name: str, bandwidth: float) -> DutyRecord:
    drive = load_drive(name).replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    speed = 0.5 * drive.rating.base_speed_rpm
    run = torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in (0.0, 0.6, 0.3, -0.2)])
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, run, regulating(bandwidth))
    assert isinstance(record, DutyRecord)
    return record


def judged(name: str, bandwidth: float, declared: float | None) -> Margin:
    record = replace(steps(name, bandwidth), declaration=Declaration(current_bandwidth=declared))
    margin: Margin | None = CHECKS["STP-1"].evaluate(record)
    assert margin is not None
    return margin


@pytest.mark.parametrize("name", ["pm-ac-surface", "pm-ac-interior"])
def test_a_usual_bandwidth_passes_where_it_is_declared(name: str) -> None:
    assert name == "pm-ac-interior" or not judged(name, USUAL, None).met
    declared = judged(name, USUAL, USUAL)
    assert declared.met
    assert "are allowed by the declared 1000 rad/s" in declared.measured


@pytest.mark.parametrize("name", ["pm-ac-surface", "pm-ac-interior"])
def test_a_loop_that_is_slower_than_declared_fails(name: str) -> None:
    assert not judged(name, 0.7 * USUAL, USUAL).met
    assert judged(name, 0.7 * USUAL, 0.7 * USUAL).met


def test_a_fast_declaration_is_a_promise_too() -> None:
    assert judged("pm-ac-surface", 2000.0, None).met
    assert not judged("pm-ac-surface", 2000.0, 8000.0).met


def test_a_witness_need_not_keep_the_promise_of_another() -> None:
    run = steps("pm-ac-surface", 2000.0).scenario
    loaded = own_candidate(
        replace(resolve_candidate("foc"), declaration=Declaration(current_bandwidth=8000.0))
    )
    failed = judged("pm-ac-surface", 2000.0, 8000.0)
    ending = hear_witnesses(loaded, Accusation("STP-1", ((run.to_mapping(), failed),)))
    assert isinstance(ending, Defence)


def test_the_limit_is_that_of_a_loop_of_first_order_behind_the_delay() -> None:
    assert min(allowed("pm-ac-surface")) == pytest.approx(np.log(10.0) / USUAL + 3e-4)


def test_torque_of_reluctance_rises_later_than_its_currents_and_falls_sooner() -> None:
    rising, falling, _ = allowed("pm-ac-interior")
    assert falling < np.log(10.0) / USUAL + 3e-4 < rising


def test_a_loop_that_asks_for_more_than_the_voltage_is_slowed_by_it() -> None:
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    free, edge, limited, late = (
        declared_rise_s(drive, USUAL, voltage_time=time) for time in (0.0, 1e-3, 3e-3, 1.0)
    )
    assert edge == free, "the voltage is just used up at the begin"
    assert limited == pytest.approx(2e-3 + np.log(10.0 / 3.0) / USUAL + 3e-4)
    assert late == pytest.approx(0.9 + 3e-4), "it is until 90 % are reached"


def allowed(name: str) -> list[float]:
    declared = replace(steps(name, USUAL), declaration=Declaration(current_bandwidth=USUAL))
    return [response.allowed_s for response in step_responses(declared)]


@pytest.mark.parametrize("bandwidth", [0.1, 195.0, 10_500.0, 1e6])
def test_no_declaration_switches_the_check_off(bandwidth: float) -> None:
    drive = load_drive("pm-ac-surface")
    with pytest.raises(
        InputError, match=r"on the drive 'pm-ac-surface' must be from 197 to 10471: a slower loop"
    ):
        check_outcomes((), Declaration(current_bandwidth=bandwidth), drive, complete=False)


def test_the_slowest_declaration_takes_ten_times_what_the_drive_states() -> None:
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    assert declared_rise_s(drive, 197.0) <= 10.0 * 12.0 * drive.control_period_s
    assert transient_periods(drive, Declaration(current_bandwidth=197.0)) > 300
    slower = drive.replaced(rise_periods=120.0)
    check_outcomes((), Declaration(current_bandwidth=50.0), slower, complete=False)


def test_the_limit_names_what_is_declared() -> None:
    limit = on_drive(CHECKS["STP-1"], load_drive("pm-ac-surface"), Declaration(current_bandwidth=USUAL)).limit
    assert "90 % of the currents within 2.603 ms, by the declared bandwidth of 1000 rad/s" in limit


def test_without_a_declaration_a_large_step_takes_what_the_loop_of_a_small_one_does_with_the_voltage() -> (
    None
):
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    rise = drive.requirements.rise_periods * drive.control_period_s
    small, large = (limited_rise_s(drive, 0.1, 10.0, time) for time in (0.0, 4.0 * rise))
    assert small == pytest.approx(rise)
    assert 0.9 * 7.2 * rise < large < 7.3 * rise, "the time of the voltage is not added to that of the loop"
    assert limited_rise_s(drive, 0.1, 1e-3, 1.0) == pytest.approx(rise + 1e-3), "as long as before at most"
    assert limited_rise_s(drive.replaced(rise_periods=2.0), 0.1, 1e-3, 0.0) == pytest.approx(
        1e-3 + 2.0 * drive.control_period_s
    ), "behind so long a delay no loop is that fast"


def test_the_straight_way_takes_no_longer_than_with_the_voltage_that_both_ends_leave() -> None:
    """A fall of the torque is driven by the EMF too, so that it takes a fraction of the rise."""
    drive = load_drive("pm-ac-interior").replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    run = torque_scenario(drive, 1200.0, [torque_of(drive, 1200.0, share) for share in (0.9, -0.9, 0.9)])
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, run, loaded.controller())
    assert isinstance(record, DutyRecord)
    fall, rise = torque_steps(record)
    for step in (fall, rise):
        assert straight_time_s(record, step) < voltage_time_s(record, step)
    assert straight_time_s(record, fall) < 0.7 * straight_time_s(record, rise)
    for response in step_responses(record):
        assert response.margin.met, response.margin.measured
