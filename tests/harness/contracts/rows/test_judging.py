"""What a row says of a run: in which windows it looks, what it measures there, and by how much it is met."""

from __future__ import annotations

import numpy as np
import pytest
from tests.harness.contracts.rows.synthetic import (
    CONTRACT,
    DUTY,
    INTERIOR,
    judged,
    record_of,
    row,
    times_of,
)

from drivegate.checks.check import NotRun
from drivegate.contracts.duty.scenarios.building import (
    failing,
    load_step_scenario,
    speed_scenario,
    torque_scenario,
)
from drivegate.contracts.rows.checks import row_check
from drivegate.contracts.rows.judging import margin_of, moment_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument

assert isinstance(INTERIOR, PmAcDocument)
STEP = load_step_scenario(INTERIOR, 1000.0, 1.0, (0.0, 1.0))
AT = next(time for time, share in STEP.load_profile if share == 1.0)
SETTLED = row(
    when="step of load",
    between_s=(0.01, 0.05),
    quantity="speed_deviation_rpm",
    statistic="absolute",
    at_most=20.0,
)


def dip(depth: float, until_s: float) -> np.ndarray:
    """Return a speed that is off its reference from the step on, for a while."""
    after = times_of(STEP) - AT
    return 1000.0 - np.where((after >= -1e-9) & (after < until_s), depth, 0.0)


@pytest.mark.parametrize(("until_s", "value"), [(0.009, 1.0), (0.02, -1.0)])
def test_a_deviation_counts_from_the_begin_of_the_window(until_s: float, value: float) -> None:
    margin = judged(SETTLED, STEP, speed_rpm=dip(40.0, until_s), speed_reference_rpm=1000.0)
    assert margin is not None
    assert margin.value == pytest.approx(value)
    assert ("40 rpm" in margin.measured) is (value < 0.0)


def test_a_window_ends_with_its_own_end() -> None:
    late = 1000.0 - np.where(times_of(STEP) - AT > 0.0501, 40.0, 0.0)
    margin = judged(SETTLED, STEP, speed_rpm=late, speed_reference_rpm=1000.0)
    assert margin is not None
    assert margin.value == 1.0


def test_nothing_is_judged_where_another_change_came_first() -> None:
    again = (*STEP.load_profile, (AT + 0.005, 1.0), (AT + 0.005, 0.5))
    changed = STEP.replaced(load=STEP.load.model_copy(update={"factor": again}))
    assert judged(SETTLED, changed, speed_rpm=dip(40.0, 1.0), speed_reference_rpm=1000.0) is None


def test_a_step_counts_alone_unless_the_row_says_otherwise() -> None:
    both = STEP.replaced(speed_rpm=((0.0, 1000.0), (AT, 1000.0), (AT, 1200.0)))
    signals = {"speed_rpm": dip(40.0, 1.0), "speed_reference_rpm": 1000.0}
    assert judged(SETTLED, both, **signals) is None
    any_step = SETTLED.model_copy(update={"when": SETTLED.when.model_copy(update={"alone": False})})
    assert judged(any_step, both, **signals) is not None


def test_a_row_of_the_speed_says_nothing_of_a_run_that_follows_a_torque() -> None:
    held = torque_scenario(INTERIOR, 1000.0, (0.0, 1.0))
    one = row(quantity="speed_deviation_rpm", statistic="absolute", at_most=20.0)
    assert judged(one, held, speed_rpm=0.0, speed_reference_rpm=1000.0) is None
    one = row(
        when="step of torque reference", quantity="torque_deviation_nm", statistic="mean", within=(-0.1, 0.1)
    )
    margin = judged(one, held, torque_nm=0.95, torque_reference_nm=1.0)
    assert margin is not None
    assert margin.value == pytest.approx(0.5)


@pytest.mark.parametrize(("reached_s", "met"), [(0.02, True), (0.04, False), (9.0, False)])
def test_a_time_until_is_that_from_which_a_quantity_stays(reached_s: float, met: bool) -> None:
    one = row(
        when="step of load",
        quantity="speed_deviation_rpm",
        statistic="time until",
        until=(-20.0, 20.0),
        at_most=0.03,
    )
    margin = judged(one, STEP, speed_rpm=dip(40.0, reached_s), speed_reference_rpm=1000.0)
    assert margin is not None
    assert margin.met is met
    assert ("not reached" in margin.measured) is (reached_s == 9.0)
    if reached_s < 9.0:
        assert margin.value == pytest.approx((0.03 - reached_s) / 0.03, abs=0.01)


def test_a_time_that_the_run_did_not_last_for_is_not_judged() -> None:
    one = row(when="start", statistic="time until", until=(900.0, 1100.0), at_most=60.0)
    assert judged(one, STEP, speed_rpm=0.0) is None
    assert judged(one, STEP, speed_rpm=1000.0) is not None


def test_a_state_begins_a_window_each_time_that_it_holds() -> None:
    time = times_of(STEP)
    slow = np.where((time % 0.1) < 0.05, 5.0, 1000.0)
    current = np.where((time % 0.1) < 0.01, 9.0, np.where((time % 0.1) < 0.05, 2.0, 30.0))
    one = row(when={"speed_rpm": (-10.0, 10.0)}, between_s=(0.02,), quantity="peak_current_a", at_most=4.0)
    margin = judged(one, STEP, speed_rpm=slow, peak_current_a=current)
    assert margin is not None
    assert margin.value == 0.5
    backward = row(when={"direction": "backward"}, quantity="peak_current_a", at_most=4.0)
    assert judged(backward, STEP, speed_rpm=slow, peak_current_a=current) is None
    assert judged(backward, STEP, speed_rpm=-slow, peak_current_a=current) is not None


def test_the_size_of_a_step_decides_with_the_row() -> None:
    size = 100.0 / INTERIOR.rating.rated_torque_nm
    signals = {"speed_rpm": 1000.0, "speed_reference_rpm": 1000.0}
    for limits, is_judged in (((size - 1.0, size + 1.0), True), ((size + 1.0, 300.0), False)):
        when = {"event": "step of load", "step_percent": limits}
        one = row(when=when, quantity="speed_deviation_rpm", at_most=20.0)
        assert (judged(one, STEP, **signals) is not None) is is_judged


def test_nothing_is_judged_after_a_failure_but_by_its_event() -> None:
    broken = failing(speed_scenario(INTERIOR, (1000.0,)), "stuck-current", 0.1)
    current = np.where(times_of(broken) >= 0.1, 50.0, 2.0)
    always = judged(row(quantity="peak_current_a", at_most=4.0), broken, peak_current_a=current)
    assert always is not None
    assert always.value == 0.5
    after = row(when="failure", between_s=(0.01,), quantity="peak_current_a", at_most=4.0)
    margin = judged(after, broken, peak_current_a=current)
    assert margin is not None
    assert not margin.met


def test_a_mean_over_stretches_is_that_of_the_worst_one() -> None:
    time = times_of(STEP)
    power = np.where((time >= 0.1) & (time < 0.12), 500.0, 100.0)
    short = row(quantity="input_power_w", statistic="mean", for_s=0.02, at_most=250.0)
    margin = judged(short, STEP, input_power_w=power)
    assert margin is not None
    assert margin.value == pytest.approx(-1.0, abs=0.01)
    whole = judged(row(quantity="input_power_w", statistic="mean", at_most=250.0), STEP, input_power_w=power)
    assert whole is not None
    assert whole.met


def test_a_limit_of_zero_is_a_share_of_the_rating() -> None:
    margin = judged(row(at_most=0.0), STEP, speed_rpm=0.1 * INTERIOR.rating.highest_speed_rpm)
    assert margin is not None
    assert margin.value == pytest.approx(-0.1)


def test_what_is_not_finite_is_missed_and_said() -> None:
    margin = judged(row(at_most=1.0), STEP, speed_rpm=np.nan)
    assert margin is not None
    assert not margin.met


def test_an_unseen_run_shows_whether_a_row_may_judge_it() -> None:
    unseen = DUTY.unseen(record_of(STEP).declaration, STEP)
    with pytest.raises(NotRun):
        margin_of(SETTLED, DUTY, unseen)
    assert margin_of(row(when="failure", at_most=1.0), DUTY, unseen) is None


def test_the_moment_has_the_limits_about_the_reference() -> None:
    record = record_of(STEP, speed_rpm=dip(40.0, 0.02), speed_reference_rpm=1000.0)
    moment = moment_of(SETTLED, CONTRACT, record)
    assert moment is not None
    assert moment.column == "speed_rpm"
    assert moment.origin_s == AT
    assert [level.value for level in moment.levels] == [980.0, 1020.0]
    assert moment.point is not None
    assert moment.point.value == 960.0


def test_a_text_with_braces_is_no_number_of_the_drive() -> None:
    from drivegate.contracts.catalogue import on_drive

    check = row_check(DUTY, row(text="The state {on} is kept.", at_most=1.0))
    assert on_drive(check, INTERIOR).requirement == "The state {on} is kept."
