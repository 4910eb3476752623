"""Comparing controllers of duty ratios: the plan, what is measured, and who is first."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.comparison import POINTS, ComparisonRequest
from drivegate.contracts.duty.comparison.declaration import COMPARISON, EFFORTS, planned_duty_runs
from drivegate.studies.compare.compared_drive import _common_reference
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.engine import Compared, labelled
from drivegate.studies.compare.engine import measured as run_and_measure
from drivegate.studies.compare.ranking import ranking_rows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.drive_cycle import load_drive_cycle
from drivegate_cases.scenario.load import ConstantTorqueLoad, DynamometerLoad
from drivegate_cases.scenario.reference import Reference

Row = dict[str, Any]


def surface() -> PmAcDocument:
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    return drive


def request(effort: str = "quick", reference: Reference = "torque") -> ComparisonRequest:
    return ComparisonRequest(surface(), effort, 0, load_drive_cycle("ece-15"), reference)


PLAN = planned_duty_runs(request())
LOADS = planned_duty_runs(request(reference="speed"))


@cache
def measured(candidate: str, index: int) -> Row:
    return run_and_measure(own_candidate(resolve_candidate(candidate)), PLAN[index])


def found(candidate: str, group: str, speed: float) -> list[Row]:
    index = next(
        index
        for index, planned in enumerate(PLAN)
        if planned.group == group and planned.scenario.speed_rpm[0][1] == speed
    )
    rows: list[Row] = measured(candidate, index)[group]
    return rows


def compared(*names: str) -> list[Compared]:
    made = labelled(names, names)
    for one in made:
        one.candidate = resolve_candidate(one.specification)
    return made


def named(names: str) -> list[Compared]:
    made = labelled(names, names)
    for one in made:
        one.candidate = resolve_candidate("foc")
    return made


def ranked(names: str, points: list[Row], steps: list[Row]) -> list[Row]:
    return ranking_rows(named(names), COMPARISON.ranking, {POINTS: points, "steps": steps})


def point(candidate: str, reference: float, *, held: bool = True, loss: float | None = 1.0) -> Row:
    return {
        "candidate": candidate,
        "speed_rpm": 100.0,
        "reference_nm": reference,
        "held": held,
        "loss_above_least_percent": loss,
        "current_above_least_percent": 1.0,
        "ripple_percent": 2.0,
    }


@pytest.mark.parametrize("effort", EFFORTS)
def test_the_plan_goes_from_slow_to_weakening_by_torques_in_reach(effort: str) -> None:
    drive = surface()
    plan = planned_duty_runs(request(effort))
    speeds = [planned.scenario.speed_rpm[0][1] for planned in plan if planned.group == "points"]
    assert speeds == sorted(set(speeds))
    assert speeds[0] < 0.2 * drive.rating.base_speed_rpm
    assert speeds[-1] == drive.rating.highest_speed_rpm
    for planned in plan:
        assert isinstance(planned.scenario.load, DynamometerLoad)
        assert len({planned.label for planned in plan}) == len(plan)


def test_losses_distinguish_least_current_from_least_loss() -> None:
    by_current, by_loss = (found(name, "points", 1650.0) for name in ("foc", "foc-loss-model"))
    assert [row["held"] for row in (*by_current, *by_loss)] == [True] * 6
    assert by_current[0]["loss_above_least_percent"] > 10.0 > 1.0 > by_loss[0]["loss_above_least_percent"]
    assert by_current[0]["current_above_least_percent"] < 10.0 < by_loss[0]["current_above_least_percent"]
    assert all(0.0 < row["ripple_percent"] < 10.0 for row in by_current)


def test_torque_that_is_missing_without_weakening_is_not_held() -> None:
    rows = found("foc-mtpa", "points", 1650.0)
    assert not any(row["held"] for row in rows)


def test_steps_are_measured_as_the_check_does() -> None:
    rows = found("foc", "steps", 330.0)
    assert len(rows) == 4, "four steps that the voltage leaves room for"
    assert all(0.0 < row["rise_ms"] < row["allowed_ms"] for row in rows)
    assert all(0.0 <= row["overshoot_percent"] < 10.0 for row in rows)


def test_who_holds_more_is_first_then_who_loses_less() -> None:
    points = [
        *(point("a", torque, loss=5.0) for torque in (1.0, 2.0)),
        point("b", 1.0, loss=0.0),
        point("b", 2.0, held=False, loss=0.0),
        *(point("c", torque, loss=2.0) for torque in (1.0, 2.0)),
        *(point("d", torque, loss=2.05) for torque in (1.0, 2.0)),
    ]
    rows = ranked("abcd", points, [])
    assert [(row["candidate"], row["rank"]) for row in rows] == [("c", 1), ("d", 1), ("a", 3), ("b", 4)]
    assert rows[-1]["points_held"] == 1


def test_a_rise_that_is_not_reached_is_no_number() -> None:
    step = {"candidate": "a", "rise_ms": None, "allowed_ms": 1.0, "overshoot_percent": 0.0}
    (row,) = ranked("a", [point("a", 1.0)], [step])
    assert row["rise_worst_percent_of_allowed"] is None


def test_the_document_has_what_was_measured() -> None:
    (one,) = made = compared("foc")
    one.figures = {4: measured("foc", 4)}
    document = comparison_document(made, PLAN, {}, request(), checks=False, timing={"seconds": 1.0})
    assert document["kind"] == "duty-comparison"
    rows = document["tables"]["operating_points"]
    assert [row["speed_rpm"] for row in rows] == [1650.0] * 3
    assert rows[0]["loss_w"] == pytest.approx(measured("foc", 4)["points"][0]["loss_w"], rel=1e-5)
    assert document["tables"]["ranking"][0]["points_held"] == 3
    assert document["tables"]["checks"] == []


def test_a_plan_of_speeds_has_the_points_of_that_of_torques_and_no_steps() -> None:
    torques = {
        (planned.scenario.speed_rpm[0][1], torque)
        for planned in PLAN
        if planned.group == "points" and isinstance(load := planned.scenario.load, DynamometerLoad)
        for _, torque in load.torque_reference_nm
    }
    loads = {
        (planned.scenario.speed_rpm[0][1], load.torque_nm)
        for planned in LOADS
        if isinstance(load := planned.scenario.load, ConstantTorqueLoad)
    }
    assert loads == torques
    assert {planned.group for planned in LOADS} == {"points"}


def test_a_loaded_point_states_its_load_and_what_goes_in() -> None:
    (row,) = run_and_measure(own_candidate(resolve_candidate("foc")), LOADS[7])["points"]
    assert row["held"] is True
    assert row["torque_nm"] == pytest.approx(row["reference_nm"], rel=0.05), "friction is small"
    mechanical = row["torque_nm"] * row["speed_rpm"] * math.pi / 30.0
    assert row["input_power_w"] == pytest.approx(mechanical + row["loss_w"], rel=0.02)


def test_candidates_that_follow_a_speed_alone_choose_the_plan() -> None:
    both, speed, torque = named("abc")
    assert speed.candidate is not None
    assert torque.candidate is not None
    assert _common_reference([both]) == "torque"
    for compared, follows in ((speed, "speed"), (torque, "torque")):
        assert compared.candidate is not None
        declaration = replace(compared.candidate.declaration, references=(follows,))
        compared.candidate = replace(compared.candidate, declaration=declaration)
    assert _common_reference([both, torque]) == "torque"
    assert _common_reference([both, speed, torque]) == "speed"
    assert speed.error is None
    assert "follows no speed, which this comparison gives" in str(torque.error)
    declaration = replace(torque.candidate.declaration, references=("current",))
    torque.candidate = replace(torque.candidate, declaration=declaration)
    assert _common_reference([both, torque]) == "speed"
    assert "follows a q current alone, but a comparison gives speeds or torques" in str(torque.error)
