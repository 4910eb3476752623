"""ROB-4: which responses of a speed are judged, over which step, and what swings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import Run, judged, with_column

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.duty.checks.speed_response import judged_step_rpm, overshoot_of_speed, regulated_rpm
from drivegate.contracts.duty.record import DutyRecord, unseen_duty_record
from drivegate.contracts.duty.scenarios.building import (
    lifted_scenario,
    load_step_scenario,
    restarted,
    speed_and_load_step_scenario,
    speed_scenario,
    supply_step_scenario,
    torque_of,
    with_lost_samples,
)
from drivegate.contracts.duty.scenarios.reaching import reaction_s
from drivegate.contracts.duty.scenarios.released import stalled_scenario
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate.scenarios.changes import with_scales
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM


def _steps(scenario: Scenario) -> list[float]:
    record = unseen_duty_record(NOTHING_DECLARED, scenario)
    return [judged_step_rpm(record, dwell) for dwell in duty_dwells(scenario)]


def _loaded(drive: PmAcDocument, *speeds: float, **keys: Any) -> Scenario:
    return speed_scenario(drive, speeds, torque_nm=torque_of(drive, max(speeds), 0.5), **keys)


def test_a_step_counts_from_a_settled_speed_or_from_the_start(interior: PmAcDocument) -> None:
    assert _steps(_loaded(interior, 1000.0, 1500.0, 1200.0)) == [0.0, 500.0, -300.0]
    assert _steps(_loaded(interior, 1500.0, initial_speed_rpm=1000.0)) == [500.0]
    assert _steps(load_step_scenario(interior, 1000.0, 1.0, (0.0, 1.0))) == [0.0, 0.0]


def test_a_step_from_a_speed_that_had_no_time_to_settle_is_not_judged(interior: PmAcDocument) -> None:
    run = _loaded(interior, 1500.0, 1200.0, initial_speed_rpm=1000.0)
    assert _steps(run) == [500.0, -300.0]
    soon = run.replaced(speed_rpm=((0.0, 1500.0), (0.1, 1500.0), (0.1, 1200.0)))
    assert _steps(soon) == [500.0, 0.0]


def test_a_ramp_is_not_judged(interior: PmAcDocument) -> None:
    run = _loaded(interior, 1000.0, 1500.0)
    (begin, _), (time, _), (_, end) = run.speed_rpm
    assert _steps(run.replaced(speed_rpm=((begin, 1000.0), (time, 1000.0), (time + 0.01, end)))) == [0.0, 0.0]


@pytest.mark.parametrize(
    ("end", "shares", "step"),
    [
        (1500.0, (0.2, 0.7), 500.0),
        (1500.0, (0.7, 0.2), 0.0),
        (800.0, (0.7, 0.2), -200.0),
        (800.0, (0.2, 0.7), 0.0),
    ],
)
def test_what_a_load_takes_in_the_sense_of_the_step_is_no_overshoot(
    interior: PmAcDocument, end: float, shares: tuple[float, float], step: float
) -> None:
    run = speed_and_load_step_scenario(interior, (1000.0, end), torque_of(interior, 1500.0, 1.0), shares)
    assert _steps(run) == [0.0, step]


def test_a_run_that_begins_too_fast_under_load_is_slowed_by_the_load(interior: PmAcDocument) -> None:
    assert _steps(_loaded(interior, 1000.0, initial_speed_rpm=1200.0)) == [0.0]
    assert _steps(speed_scenario(interior, (1000.0,), initial_speed_rpm=1200.0)) == [-200.0]
    backward = _loaded(interior, 1000.0, initial_speed_rpm=-1000.0)
    assert _steps(backward) == [0.0], "the load stops the shaft as the regulator does"


def test_a_step_with_another_event_is_not_judged(interior: PmAcDocument) -> None:
    run = _loaded(interior, 1000.0, 1500.0)
    time = run.speed_rpm[-1][0]
    share = time / run.duration_s
    assert _steps(restarted(run, (share,)))[-1] == 0.0
    assert _steps(with_lost_samples(run, ("speed",), (share,)))[-1] == 0.0
    assert (
        _steps(supply_step_scenario(run, interior, (1.0, 0.9)).replaced(duration_s=run.duration_s))[1] == 0.0
    )
    lifted = lifted_scenario(interior, 1000.0, 1.0, (2.0, 0.3))
    assert _steps(lifted.replaced(speed_rpm=run.speed_rpm))[1:] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("begin", "end", "magnets", "step"),
    [
        (1000.0, 1500.0, 0.8, 0.0),
        (-1000.0, -1500.0, 0.8, 0.0),
        (1500.0, 1000.0, 0.8, -500.0),
        (1500.0, 1000.0, 1.05, 0.0),
        (1000.0, 1500.0, 1.05, 500.0),
        (0.0, 1500.0, 0.8, 1500.0),
    ],
)
def test_what_other_magnets_push_where_a_run_begins_turning_is_no_overshoot(
    interior: PmAcDocument, begin: float, end: float, magnets: float, step: float
) -> None:
    scenario = speed_scenario(interior, (end, 1200.0), initial_speed_rpm=begin)
    assert _steps(with_scales(scenario, emf_constant=magnets)) == [step, 1200.0 - end]


@pytest.mark.parametrize(("begins", "is_met"), [([-100.0], False), ([-100.0, -150.0], True)])
def test_an_overshoot_is_judged_over_the_way_that_the_speed_came(
    interior: PmAcDocument, begins: list[float], is_met: bool
) -> None:
    """A load that comes on with a small step takes the speed farther away, and it returns from there."""
    beyond = np.array([*begins, 0.0, 70.0, 0.0, -900.0])
    for sign in (1.0, -1.0):
        margin = overshoot_of_speed(sign * beyond, sign * 100.0, 1.0, interior)
        assert margin.met == is_met, margin.measured


def test_only_the_part_of_a_great_step_that_is_left_to_the_regulator_counts(interior: PmAcDocument) -> None:
    """The rest is made with the greatest torque, whatever the regulator's gains."""
    made = regulated_rpm(interior)
    assert 200.0 < made < 300.0
    for share, is_met in ((0.54, True), (0.56, False)):
        beyond = np.array([-3000.0, 0.0, share * made, 0.0])
        margin = overshoot_of_speed(beyond, 3000.0, 1.0, interior)
        assert margin.met == is_met, margin.measured


def test_what_a_steady_speed_may_be_off_by_is_no_overshoot(interior: PmAcDocument) -> None:
    tolerance = 2.0 * limits_of(interior).speed_tolerance_rpm
    for share, is_met in ((0.99, True), (1.01, False)):
        beyond = np.array([-10.0, 0.0, share * tolerance, 0.0])
        assert overshoot_of_speed(beyond, 10.0, 0.0, interior).met == is_met


@pytest.mark.parametrize("scales", [{}, {"inertia": 0.5}])
def test_an_overshoot_is_judged_on_every_plant_by_one_limit(
    run: Run, interior: PmAcDocument, scales: dict[str, float]
) -> None:
    record = run(with_scales(_loaded(interior, 1000.0, 1200.0), **scales))
    margin = judged("ROB-4", record)
    assert margin is not None
    assert margin.met, margin.measured
    assert overshot(record, 0.5).met
    assert not overshot(record, 0.6).met
    other = record.scenario.drive.replaced(speed_overshoot_percent=70.0)
    assert overshot(run(record.scenario.replaced(drive=other)), 0.6).met


def overshot(record: DutyRecord, share: float) -> Any:
    """Judge a run whose last step overshoots by a share of its 200 rpm for 10 ms."""
    start = record.periods(record.steady[-1].dwell.start, 0.0).start + 1500
    over = (1200.0 + share * 200.0) * RADIANS_PER_RPM

    def change(speed: Any) -> Any:
        changed = speed.copy()
        changed[start : start + 100] = over
        return changed

    return judged("ROB-4", with_column(record, "speed", change))


def test_a_shaft_that_comes_free_may_run_away_until_its_torque_is_taken_back(
    run: Run, interior: PmAcDocument
) -> None:
    light = interior.replaced(inertia_kg_m2=interior.machine.inertia_kg_m2 / 60.0)
    record = run(stalled_scenario(light, 300.0, 0.3))
    margin = judged("ROB-4", record)
    assert margin is not None
    assert margin.met, margin.measured
    without = judged("ROB-4", with_column(record, "torque", np.zeros_like))
    assert without is not None
    assert not without.met, "nothing was stored against the stall"


@pytest.mark.parametrize(("growth", "is_met"), [(0.0, True), (8.0, False)])
def test_a_slow_swing_that_lasts_does_not_grow(
    run: Run, interior: PmAcDocument, growth: float, is_met: bool
) -> None:
    record = run(_loaded(interior, 1000.0))
    time = np.arange(len(record.run.trace)) * interior.control_period_s
    window = record.steady[-1]
    phase = (
        2.0
        * np.pi
        * (time - 0.75 * window.end_s - 0.25 * window.start_s)
        / (2.0 * (window.end_s - window.start_s))
    )
    swing = 60.0 * RADIANS_PER_RPM * np.exp(growth * (time - window.end_s) / (window.end_s - window.start_s))
    margin = judged("ROB-4", with_column(record, "speed", lambda speed: speed + swing * np.sin(phase)))
    assert margin is not None
    assert margin.met == is_met, margin.measured


def test_a_speed_that_still_settles_names_the_key(run: Run, interior: PmAcDocument) -> None:
    record = run(_loaded(interior, 1000.0))
    late = with_column(record, "speed", lambda speed: speed - 100.0 * np.exp(-np.arange(len(speed)) / 1500.0))
    margin = judged("ACC-1", late)
    assert margin is not None
    assert not margin.met
    assert "still settling: requirements.settling_s is 0.4 s" in margin.measured
    off = judged("ACC-1", with_column(record, "speed", lambda speed: speed - 10.0))
    assert off is not None
    assert "settling_s" not in off.measured


def _regulated(
    drive: PmAcDocument,
    step_rpm: float,
    inertia_factor: float,
    *,
    slowness: float = 0.5,
    integral: float = 1.0,
    gain: float = 1.0,
    filters: bool = False,
    winds_up: bool = False,
) -> Any:
    """Judge the step of a symmetrical optimum with a = 2 on a shaft without load, by its own simulation.

    `slowness` is its reaction time over that of the slowest regulator; its torque has a first-order lag.
    """
    greatest = regulated_rpm(drive) * RADIANS_PER_RPM * drive.machine.inertia_kg_m2 / reaction_s(drive)
    reaction, inertia = slowness * reaction_s(drive), drive.machine.inertia_kg_m2
    lag, integral_time = 0.5 * reaction, 2.0 * reaction / integral
    proportional = gain * inertia / reaction
    step, period = step_rpm * RADIANS_PER_RPM, lag / 30.0
    speed = torque = stored = filtered = 0.0
    beyond = []
    for _ in range(round((20.0 * reaction + 3.0 * inertia * inertia_factor * step / greatest) / period)):
        filtered += period / (2.0 * reaction) * (step - filtered) if filters else step - filtered
        error = filtered - speed
        requested = proportional * error + stored
        possible = min(max(requested, -greatest), greatest)
        if winds_up or possible == requested or (requested - possible) * error < 0.0:
            stored += period * proportional * error / integral_time
        torque += period / lag * (possible - torque)
        speed += period * torque / (inertia_factor * inertia)
        beyond.append((speed - step) / RADIANS_PER_RPM)
    return overshoot_of_speed(np.array(beyond), step_rpm, 0.0, drive)


@pytest.mark.parametrize("inertia_factor", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("filters", [False, True])
def test_a_symmetrical_optimum_does_not_overshoot_too_far(
    interior: PmAcDocument, inertia_factor: float, filters: bool
) -> None:
    for step in (20.0, 100.0, 300.0, 1000.0, 3000.0):
        margin = _regulated(interior, step, inertia_factor, filters=filters)
        assert margin.met, margin.measured


@pytest.mark.parametrize(
    ("step", "keys"),
    [
        (100.0, {"integral": 6.0}),
        (100.0, {"integral": 2.5, "gain": 0.4}),
        (3000.0, {"winds_up": True}),
        (3000.0, {"winds_up": True, "slowness": 0.1}),
    ],
    ids=["eager integral", "weak gain", "windup", "windup of a fast one"],
)
def test_a_regulator_with_another_integral_overshoots(
    interior: PmAcDocument, step: float, keys: dict[str, Any]
) -> None:
    margin = _regulated(interior, step, 1.0, **keys)
    assert not margin.met, margin.measured


@pytest.mark.parametrize("speeds", [(1000.0, 1100.0), (1000.0, 900.0), (-1000.0, -900.0)])
def test_a_step_alone_may_not_move_the_speed_away_from_the_new_reference(
    interior: PmAcDocument, run: Run, speeds: tuple[float, float]
) -> None:
    """What a cleared integral does: the shaft first falls by what it carried of the load."""
    record = run(_loaded(interior, *speeds))
    rows = record.periods(record.steady[1].dwell.start, record.steady[1].dwell.end)
    away = np.sign(speeds[0] - speeds[1]) * RADIANS_PER_RPM

    def detour(rpm: float) -> Any:
        def changed(speed: Any) -> Any:
            moved = speed.copy()
            moved[rows.start + 5 : rows.start + 50] = speeds[0] * RADIANS_PER_RPM + rpm * away
            return moved

        return judged("ROB-4", with_column(record, "speed", changed))

    allowed = 2.0 * limits_of(interior).speed_tolerance_rpm
    near, far = detour(0.9 * allowed), detour(1.1 * allowed)
    assert near is not None
    assert near.met, near.measured
    assert far is not None
    assert not far.met
    assert "away from a reference 100 rpm off" in far.measured


def test_a_load_that_comes_on_with_the_step_may_move_the_speed_away(interior: PmAcDocument, run: Run) -> None:
    scenario = speed_and_load_step_scenario(
        interior, (1000.0, 1100.0), torque_of(interior, 1100.0, 0.8), (0.1, 1.0)
    )
    record = run(scenario)
    rows = record.periods(record.steady[1].dwell.start, record.steady[1].dwell.end)
    assert np.min(record.run.column("speed")[rows]) < 950.0 * RADIANS_PER_RPM
    margin = judged("ROB-4", record)
    assert margin is not None
    assert margin.met, margin.measured


def test_a_load_step_may_take_a_settled_speed_as_far_as_a_slow_regulator_lets_it(
    interior: PmAcDocument, run: Run
) -> None:
    torque = torque_of(interior, 1000.0, 0.8)
    record = run(load_step_scenario(interior, 1000.0, torque, (0.0, 1.0)))
    rows = record.periods(record.steady[1].dwell.start, record.steady[1].dwell.end)
    moved = torque * reaction_s(interior) / interior.machine.inertia_kg_m2

    def sagging(share: float) -> Any:
        def changed(speed: Any) -> Any:
            sagged = speed.copy()
            sagged[rows.start + 5 : rows.start + 50] -= share * moved
            return sagged

        return judged("ROB-4", with_column(record, "speed", changed))

    near, far = sagging(0.9), sagging(1.6)
    assert near is not None
    assert near.met, near.measured
    assert far is not None
    assert not far.met
    assert "rpm off after a load step" in far.measured
