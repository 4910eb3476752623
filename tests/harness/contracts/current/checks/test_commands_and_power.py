"""Checks of a whole run, by the smallest step on either side of their limits."""

import math

import numpy as np
import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.checks.margin import GREATEST, at_most, below, normalised

TINY = math.ulp(0.0)
RANGES = {
    "ANGLE_LOWEST": 0.1,
    "ANGLE_HIGHEST": 0.2,
    "REFERENCE_LOWEST": 1.0,
    "REFERENCE_HIGHEST": 2.0,
}


@pytest.mark.parametrize(
    ("check", "entry", "inside", "beyond"),
    [
        ("PWR-1", "EXCHANGE_ERROR", 1e-9, np.nextafter(1e-9, 1.0)),
        ("PWR-1", "EXCHANGE_ERROR", 0.0, math.nan),
        ("ADV-2", "ANGLE_LOWEST", 0.0, -TINY),
        ("ADV-2", "ANGLE_HIGHEST", math.pi / 2, np.nextafter(math.pi / 2, 2.0)),
        ("CMD-1", "REFERENCE_LOWEST", 0.0, -TINY),
        ("CMD-1", "REFERENCE_HIGHEST", 26.0, np.nextafter(26.0, 27.0)),
    ],
)
def test_limits_of_the_whole_run(record, assert_limit, check, entry, inside, beyond):
    assert_limit(check, record(run={**RANGES, entry: inside}), record(run={**RANGES, entry: beyond}))


def test_the_angle_below_base_speed_has_to_be_exactly_zero(record, assert_limit):
    below_base = {"STEPS_BELOW_BASE": 1.0}
    assert_limit(
        "ADV-1",
        record(run={**below_base, "ANGLE_BELOW_BASE": 0.0}),
        record(run={**below_base, "ANGLE_BELOW_BASE": TINY}),
    )


def test_a_run_above_base_speed_says_nothing_about_the_angle_below(record, checks):
    assert checks["ADV-1"].evaluate(record(run={"STEPS_BELOW_BASE": 0.0, "ANGLE_BELOW_BASE": 1.0})) is None


def test_the_peak_current_may_reach_the_band_but_for_rounding(record, assert_limit):
    allowed = 26.25 * (1.0 + 1e-12)
    assert_limit(
        "CUR-1",
        record(totals={"PEAK": allowed}),
        record(totals={"PEAK": np.nextafter(allowed, 27.0)}),
    )


def test_the_power_balance_shows_what_flows_back(record, checks):
    margin = checks["PWR-1"].evaluate(record(totals={"EXCHANGED": 100.0, "RETURNED": 10.0}))
    assert margin.measured == "exact; net power 20 % below the exchanged one"


def test_an_estimate_is_exact_through_ideal_sensors(record, assert_limit):
    estimates = {"POWER_ESTIMATES": 10.0, "POWER_ERROR": 1e-6}
    assert_limit(
        "PWR-2",
        record(run={**estimates, "POWER_ERROR_RELATIVE": 1e-9}),
        record(run={**estimates, "POWER_ERROR_RELATIVE": np.nextafter(1e-9, 1.0)}),
    )


def test_an_estimate_may_be_off_by_one_step_of_the_converter(record, assert_limit, scenario):
    sensed = scenario(sensors="mcs96", supply_v=[[0.0, 48.0], [5.0, 40.0]])
    # 10 bits from -40 A to 40 A, times the lowest voltage of the run.
    step = 80.0 / 1024.0 * 40.0
    estimates = {"POWER_ESTIMATES": 10.0, "POWER_ERROR_RELATIVE": 0.1}
    assert_limit(
        "PWR-2",
        record(sensed, run={**estimates, "POWER_ERROR": step}),
        record(sensed, run={**estimates, "POWER_ERROR": np.nextafter(step, 10.0)}),
    )


def test_a_small_estimate_is_judged_by_its_relative_error_too(record, assert_limit, scenario):
    sensed = scenario(sensors="mcs96")
    estimates = {"POWER_ESTIMATES": 10.0, "POWER_ERROR": 1e3}
    assert_limit(
        "PWR-2",
        record(sensed, run={**estimates, "POWER_ERROR_RELATIVE": 1e-9}),
        record(sensed, run={**estimates, "POWER_ERROR_RELATIVE": np.nextafter(1e-9, 1.0)}),
    )


def test_declared_estimates_that_are_missing_fail(record, checks):
    silent = record(run={"POWER_ESTIMATES": 0.0})
    margin = checks["PWR-2"].evaluate(silent)
    assert not margin.met, margin
    assert checks["PWR-2"].evaluate(record(declaration=Declaration())) is None


def test_repetitions_that_differ_in_one_bit(record, assert_limit):
    digest = record().run.digest
    assert_limit("DET-1", record(repeated=(digest, digest)), record(repeated=(digest, digest ^ 1)))


def test_a_scenario_that_ran_once_says_nothing_about_determinism(record, checks):
    assert checks["DET-1"].evaluate(record()) is None


@pytest.mark.parametrize("limit", [0.005, 0.13, 5.0 * math.pi / 30.0, 1e-9, 26.0])
def test_a_margin_has_the_sign_of_the_smallest_difference(limit):
    above, under = np.nextafter(limit, np.inf), np.nextafter(limit, 0.0)
    assert at_most(limit, limit) == 0.0
    assert at_most(above, limit) < 0.0 < at_most(under, limit)
    assert below(limit, limit) < 0.0 < below(under, limit)
    assert below(0.0, limit) == at_most(0.0, limit) == 1.0


def test_a_margin_keeps_its_sign_where_the_division_loses_it():
    assert normalised(-TINY, 1e9) < 0.0
    assert normalised(0.0, 1e9) == 0.0


@pytest.mark.parametrize("measured", [math.nan, math.inf, 1.7e308])
@pytest.mark.parametrize("limit", [1.0, 1e-9, 0.0, 5e-324, 1.7e308])
def test_what_is_no_number_or_too_large_is_far_beyond_any_limit(measured, limit):
    expected = 0.0 if measured == limit else -GREATEST
    assert at_most(measured, limit) == expected


def test_nothing_is_within_a_limit_of_nothing():
    assert at_most(0.0, 0.0) == 0.0
