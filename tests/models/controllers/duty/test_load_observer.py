"""The controller with an observer of shaft and load: speed without an integral, on shafts of any inertia."""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
import pytest
from tests.models.controllers.duty.test_plausibility import NAMEPLATE, RATED_TORQUE

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import (
    load_step_scenario,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.drives.running import recorded
from drivegate.scenarios.changes import with_dropout, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import HALL_POSITION
from drivegate_models.controllers.duty.load_observer import LOAD_OBSERVER_STATE, reset_state
from drivegate_models.units import RADIANS_PER_RPM

DRIVES = ("pm-ac-interior", "pm-ac-surface", "pm-ac-msl", "pm-ac-2kw")


def run(scenario: Scenario):
    loaded = own_candidate(resolve_candidate("load-observer"))
    return recorded(loaded, scenario, loaded.controller())


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("inertia", [0.3, 1.0, 2.0])
def test_the_speed_hardly_overshoots_whatever_the_inertia(name: str, inertia: float) -> None:
    drive = load_drive(name)
    base = drive.rating.base_speed_rpm
    steps = speed_scenario(drive, (0.3 * base, 0.8 * base, 0.3 * base), torque_nm=torque_of(drive, base, 0.4))
    record = run(with_scales(steps, inertia=inertia))
    speed = record.run.column("speed") / RADIANS_PER_RPM
    assert np.max(speed) < 0.83 * base
    margins = judged(record, contract_of(drive).checks).margins
    assert [margin for margin in margins if not margin.met] == []


@pytest.mark.parametrize("name", DRIVES)
def test_the_observed_load_holds_the_speed_under_a_load_step(name: str) -> None:
    drive = load_drive(name)
    speed = 0.5 * drive.rating.base_speed_rpm
    record = run(load_step_scenario(drive, speed, torque_of(drive, speed, 0.8), (0.0, 1.0, 0.5)))
    assert record.run.column("speed")[-1] == pytest.approx(speed * RADIANS_PER_RPM, rel=1e-4)
    margins = [
        margin for margin in judged(record, contract_of(drive).checks).margins if margin.check == "ACC-1"
    ]
    assert margins
    assert all(margin.met for margin in margins), margins


@pytest.mark.kernel
@pytest.mark.parametrize("share", [0.3, 1.0, 10.0])
def test_an_error_of_hall_switches_leaves_torque_for_the_load(share: float) -> None:
    """A swing that the greatest torque cuts on one side would take the mean speed off its reference."""
    error, inertia = radians(2.5), 10.0
    state: Any = np.zeros(1, LOAD_OBSERVER_STATE).view(np.recarray)[0]
    limit = share * NAMEPLATE.current_limit
    hall = {"position": HALL_POSITION, "position_error": error, "current_limit": limit}
    plate = NAMEPLATE._replace(pole_pairs=15, inertia=inertia, **hall)
    reset_state(state, duty_nameplate_record(plate).view(np.recarray)[0])
    swing = 2.0 * 15.5 * inertia * error / 15 * state.speed_rate**2
    assert swing == pytest.approx(min(2.0 * RATED_TORQUE, 0.5 * state.machine.greatest_torque))


def test_a_shaft_that_its_load_stops_between_hall_edges_is_turned_on() -> None:
    """A load that opposes the rotation acts the other way after a reversal, which no edge shows."""
    drive = load_drive("pm-ac-servo").replaced(position="hall")
    base = drive.rating.base_speed_rpm
    record = run(speed_scenario(drive, (0.9 * base, -0.35 * base), torque_nm=torque_of(drive, base, 0.65)))
    assert record.run.column("speed")[-1] == pytest.approx(-0.35 * base * RADIANS_PER_RPM, rel=0.01)


@pytest.mark.parametrize("name", DRIVES)
def test_currents_that_are_lost_for_a_sample_are_no_failure(name: str) -> None:
    drive = load_drive(name)
    base = drive.rating.base_speed_rpm
    torques = (-torque_of(drive, base, 1.0), -torque_of(drive, base, 0.6))
    steps = torque_scenario(drive, 0.1 * base, torques)
    at = steps.torque_reference_profile[-1][0]
    record = run(with_dropout(steps, "currents", at, steps.control_period_s))
    assert not record.run.commands["fault"].any()
