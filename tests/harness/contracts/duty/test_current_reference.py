"""A candidate that follows a q current gets one in place of each torque, and is judged by it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.resources import files
from runpy import run_path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.drawn_runs import drawn

from drivegate import CURRENT_REFERENCE
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_of, on_drive
from drivegate.contracts.duty.checks.steps import step_moment
from drivegate.contracts.duty.current_reference import quadrature_for
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import duty_nameplate
from drivegate.contracts.duty.scenarios.building import supply_step_scenario, torque_of, torque_scenario
from drivegate.contracts.duty.timed_steps import _senses
from drivegate.drives.running import recorded
from drivegate.gate.witnesses import Accusation, Defence, hear_witnesses
from drivegate.results.verdict import check_outcomes
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.fundamental import most_torque_per_ampere

FOLLOWS = Declaration(references=("current",))
TEMPLATE = files("drivegate.templates") / "new" / "python-duty" / "controller.py"
Template: Any = run_path(str(TEMPLATE))["Controller"]


def interior() -> PmAcDocument:
    drive = load_drive("pm-ac-interior").replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    return drive


DRIVE = interior()
CONTRACT = contract_of(DRIVE)
CHECKS = {check.id: check for check in CONTRACT.checks}
SPEED = 0.5 * DRIVE.rating.base_speed_rpm
TORQUES = tuple(torque_of(DRIVE, SPEED, share) for share in (0.0, 0.6, 0.3, -0.2))
RUN = torque_scenario(DRIVE, SPEED, TORQUES)


class Following(Template):  # type: ignore[misc]
    """Follows a q current without a d current: with an error, or with slow regulators."""

    def __init__(self, gain: float = 1.0, slower: float = 1.0) -> None:
        self.gain, self.slower = gain, slower

    def reset(self, nameplate: Any) -> None:
        super().reset(nameplate)
        assert nameplate.reference_kind == CURRENT_REFERENCE
        for name in ("direct_gain", "quadrature_gain", "direct_step", "quadrature_step"):
            setattr(self, name, getattr(self, name) * self.slower)

    def references(self, reference: float, *_: float) -> tuple[float, float]:
        return 0.0, self.gain * reference


@cache
def record_of(gain: float = 1.0, slower: float = 1.0) -> DutyRecord:
    candidate = replace(resolve_candidate("foc"), declaration=FOLLOWS)
    controller = PythonController(Following(gain, slower))
    record = recorded(JudgedCandidate(candidate, lambda: controller), RUN, controller)
    assert isinstance(record, DutyRecord)
    return record


def judged(check: str, record: DutyRecord) -> Margin:
    margin: Margin | None = CHECKS[check].evaluate(record)
    assert margin is not None
    return margin


def test_a_q_current_that_is_followed_passes_whatever_its_torque() -> None:
    record = record_of()
    short = min(record.steady, key=lambda window: window.torque - (window.torque_reference or 0.0))
    assert short.torque < 0.98 * (short.torque_reference or 0.0), "without a d current there is less torque"
    for check in ("ACC-1", "STP-1", "OVC-1", "OVC-2", "DUT-1"):
        assert judged(check, record).met, judged(check, record).measured
    assert "q current off by" in judged("ACC-1", record).measured
    assert "A of q current at" in judged("STP-1", record).measured


def test_a_q_current_that_is_missed_or_late_fails() -> None:
    assert not judged("ACC-1", record_of(gain=1.05)).met
    late = record_of(slower=0.1)
    assert not judged("STP-1", late).met
    moment = step_moment(late)
    assert moment is not None
    assert moment.column == "quadrature_current_a"
    assert moment.levels[0].value in {quadrature_for(DRIVE, torque) for torque in TORQUES}


def test_the_q_current_is_that_of_least_current_by_the_nameplate() -> None:
    reference = quadrature_for(DRIVE, 1.0)
    assert quadrature_for(DRIVE, -1.0) == pytest.approx(-reference)
    greatest = most_torque_per_ampere(DRIVE.plant(), DRIVE.rating.current_limit_a)[1]
    assert 0.0 < reference < greatest
    assert quadrature_for(DRIVE, 1e3) == pytest.approx(greatest), "no more than the current limit"
    seen = _senses(record_of(), record_of().scenario.control_periods)["reference"]
    assert set(np.unique(seen)) == {quadrature_for(DRIVE, torque) for torque in TORQUES}


def test_the_trace_shows_the_torque_of_the_scenario() -> None:
    shown = record_of().run.column("torque_reference")
    period = RUN.control_period_s
    for window in record_of().steady:
        start, end = round(window.dwell.start / period), round(window.dwell.end / period)
        assert set(shown[start:end]) == {window.torque_reference}


def test_it_is_run_on_torques_that_need_no_weakening_even_without_a_d_current() -> None:
    runs = CONTRACT.fixed_scenarios(DRIVE, FOLLOWS)
    assert len(runs) > 10
    assert {run.drive for run in runs} == {DRIVE}
    assert all(isinstance(run.load, DynamometerLoad) for run in runs)
    base = DRIVE.rating.base_speed_rpm
    assert max(abs(speed) for run in runs for _, speed in run.speed_rpm) == base
    assert any(goes < 0.0 for run in runs for _, goes in run.speed_rpm)
    low = supply_step_scenario(
        torque_scenario(DRIVE, base, (torque_of(DRIVE, base, 0.7),)), DRIVE, (1.0, 0.85, 1.15)
    )
    assert low.name not in {run.name for run in runs}


def test_drawn_runs_are_of_that_kind_too() -> None:
    @drawn(20)
    @given(st.data())
    def draw(data: st.DataObject) -> None:
        run = data.draw(CONTRACT.drawn_scenarios(DRIVE, FOLLOWS, None))
        assert run.drive == DRIVE
        assert isinstance(run.load, DynamometerLoad)
        assert max(abs(speed) for _, speed in run.speed_rpm) <= DRIVE.rating.base_speed_rpm

    draw()


def test_checks_of_the_d_current_and_of_the_torque_do_not_apply() -> None:
    outcomes = {outcome.id: outcome for outcome in check_outcomes((), FOLLOWS, DRIVE, complete=True)}
    for check in ("FWK-1", "FWK-2", "FWK-3", "MTP-1", "EFF-1"):
        assert outcomes[check].message.startswith("the candidate follows a q current: the d current")
    assert "A of q current in its place" in on_drive(CHECKS["ACC-1"], DRIVE, FOLLOWS).limit


def test_a_witness_follows_the_torque_in_the_same_scenario() -> None:
    loaded = own_candidate(replace(resolve_candidate("foc"), declaration=FOLLOWS))
    failed = judged("ACC-1", record_of(gain=1.05))
    ending = hear_witnesses(loaded, Accusation("ACC-1", ((RUN.to_mapping(), failed),)))
    assert isinstance(ending, Defence)
    assert "torque off" in ending.witnessed.measured


def test_a_built_in_controller_follows_no_current() -> None:
    loaded = own_candidate(resolve_candidate("foc"))
    with pytest.raises(InputError, match="follows a speed or a torque, but this run gives a q current"):
        loaded.controller().reset(duty_nameplate(RUN, follows_current=True))
