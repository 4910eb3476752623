"""How controllers of duty ratios behave: the torque within control periods, and what a report states."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.behaviour import behaviour
from drivegate.contracts.duty.checks.current import least_loss
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.checks.steps import step_response
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.contracts.duty.scenarios.fixed import efficiency_scenarios
from drivegate.contracts.duty.torque import torque_course
from drivegate.drives.running import recorded
from drivegate.results.sections import BehaviourSection
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


def steps_of(drive: PmAcDocument) -> Scenario:
    speed = speed_of(drive, -0.7)
    return torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in (0.0, 0.5, 0.3)])


@pytest.mark.parametrize("name", ["pm-ac-surface", "pm-ac-2kw"])
def test_the_recorded_commands_give_the_recorded_run_again(name: str) -> None:
    record = run(efficiency_scenarios(drive_of(name))[-1])
    first, count = len(record.run.trace) - 60, 60
    course = torque_course(record, first, count)
    for column, again in (("direct", course.direct), ("quadrature", course.quadrature)):
        np.testing.assert_allclose(again, record.run.column(column)[first:], atol=1e-9, err_msg=column)
    mean = record.run.column("torque")[first:]
    assert course.torque.mean == pytest.approx(float(np.mean(mean)), rel=1e-9)
    assert np.all(course.least < mean), "there is ripple within each control period"
    assert np.all(course.greatest > mean), "there is ripple within each control period"


def test_what_is_reported_agrees_with_the_checks() -> None:
    drive = drive_of("pm-ac-surface")
    stated = BehaviourSection.model_validate_json(json.dumps(behaviour(run, drive, steps_of(drive))))
    margin = step_response(run(steps_of(drive)))
    assert margin is not None
    assert stated.step is not None
    shares = (
        stated.step.overshoot_percent / stated.step.overshoot_limit_percent,
        ((stated.step.rise_ms or np.inf) / stated.step.allowed_ms),
    )
    assert margin.value == pytest.approx(1.0 - max(shares), abs=1e-4)
    assert len(stated.points) == 8, "every efficiency point was held"
    worst = min(
        (margin for scenario in efficiency_scenarios(drive) if (margin := least_loss(run(scenario)))),
        key=lambda margin: margin.value,
    )
    excess = max(point.above_least_percent or 0.0 for point in stated.points)
    assert f"{excess:.3g} % above the least loss" in worst.measured


def test_the_spectrum_shows_the_carriers_sidebands() -> None:
    drive = drive_of("pm-ac-surface")
    torque = behaviour(run, drive, None)["torque"]
    strongest = torque["frequency_hz"][int(np.argmax(torque["amplitude_percent"]))]
    apart = abs(strongest - torque["carrier_frequency_hz"]) / torque["electrical_frequency_hz"]
    assert apart == pytest.approx(3.0, abs=0.5), (
        "of a symmetric carrier three times the electrical frequency beside it"
    )
    swing = max(torque["greatest_nm"]) - min(torque["least_nm"])
    assert torque["peak_to_peak_percent"] == pytest.approx(100.0 * swing / torque["mean_nm"], rel=0.1)
