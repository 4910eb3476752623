"""Every check on both sides of its limit, from a finished run that is altered by as little as counts."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drivegate.builtin_loading import BuiltinController
from drivegate.catalogue import CHECKS
from drivegate.checks import convergence
from drivegate.declaration import Declaration
from drivegate.fixed_scenarios import base_speed_scenario, steady_scenario
from drivegate.run_record import RunRecord
from drivegate.scenario_run import RADIANS_PER_RPM, run_scenario
from drivegate_cases.motor import load_motor
from drivegate_cases.scenario import load_scenario
from drivegate_models import ledger, observation
from drivegate_models.builtin_controllers import SEARCHES
from drivegate_models.oracle import least_current_sum

BY_ID = {check.id: check for check in CHECKS}
MOTOR = load_motor("paper-5-phase")


def _record(scenario: Any) -> RunRecord:
    run = run_scenario(scenario, BuiltinController(SEARCHES["reference"]))
    return RunRecord(scenario, run, Declaration(estimates_power=True))


@pytest.fixture(scope="module")
def published_point() -> RunRecord:
    return _record(load_scenario("fig5-search"))


@pytest.fixture(scope="module")
def rated_power() -> RunRecord:
    return _record(steady_scenario(MOTOR, 900.0, power_share=1.0, constant_power=True))


@pytest.fixture(scope="module")
def through_base_speed() -> RunRecord:
    return _record(base_speed_scenario(MOTOR, 450.0, 520.0, 10.0))


def with_run(record: RunRecord, index: int, value: float) -> RunRecord:
    run = record.run.run.copy()
    run[index] = value
    return replace(record, run=replace(record.run, run=run))


def with_window(record: RunRecord, **values: float) -> RunRecord:
    windows = record.run.windows.copy()
    for name, value in values.items():
        windows[:, getattr(observation, f"WINDOW_{name}")] = value
    return replace(record, run=replace(record.run, windows=windows))


def with_peak(record: RunRecord, value: float) -> RunRecord:
    totals = record.run.totals.copy()
    totals[ledger.PEAK] = value
    return replace(record, run=replace(record.run, totals=totals))


def assert_limit(check: str, passing: RunRecord, failing: RunRecord) -> None:
    __tracebackhide__ = True
    met, missed = BY_ID[check].evaluate(passing), BY_ID[check].evaluate(failing)
    assert met is not None, f"{check} does not apply"
    assert missed is not None, f"{check} does not apply"
    assert met.met, f"{check} fails just inside its limit: {met.value} ({met.measured})"
    assert not missed.met, f"{check} passes just beyond its limit: {missed.value} ({missed.measured})"
    assert abs(met.value) < 1e-3 or met.value == 1.0, f"the passing side is not near the limit: {met.value}"


SIMPLE: list[tuple[str, Callable[[RunRecord, float], RunRecord], float, float]] = [
    ("PWR-1", lambda r, v: with_run(r, observation.RUN_EXCHANGE_ERROR, v), 1e-9, 1.0001e-9),
    ("PWR-2", lambda r, v: with_run(r, observation.RUN_POWER_ERROR_RELATIVE, v), 1e-9, 1.0001e-9),
    ("ADV-2", lambda r, v: with_run(r, observation.RUN_ANGLE_LOWEST, v), 0.0, -1e-12),
    ("ADV-2", lambda r, v: with_run(r, observation.RUN_ANGLE_HIGHEST, v), math.pi / 2, math.pi / 2 + 1e-12),
    ("CMD-1", lambda r, v: with_run(r, observation.RUN_REFERENCE_LOWEST, v), 0.0, -1e-12),
    ("CMD-1", lambda r, v: with_run(r, observation.RUN_REFERENCE_HIGHEST, v), 26.0, 26.0 + 1e-9),
    ("CUR-1", with_peak, 26.25, 26.2501),
]


@pytest.mark.parametrize(("check", "alter", "inside", "beyond"), SIMPLE)
def test_limits_of_the_whole_run(
    published_point: RunRecord,
    check: str,
    alter: Callable[[RunRecord, float], RunRecord],
    inside: float,
    beyond: float,
) -> None:
    assert_limit(check, alter(published_point, inside), alter(published_point, beyond))


def test_angle_below_base_speed_has_to_be_exactly_zero(through_base_speed: RunRecord) -> None:
    smallest = with_run(through_base_speed, observation.RUN_ANGLE_BELOW_BASE, 5e-324)
    margin = BY_ID["ADV-1"].evaluate(smallest)
    assert BY_ID["ADV-1"].evaluate(through_base_speed).met  # type: ignore[union-attr]
    # A subnormal angle rounds to zero degrees; the next one that does not has to fail.
    assert margin is not None
    assert (
        not BY_ID["ADV-1"]
        .evaluate(  # type: ignore[union-attr]
            with_run(through_base_speed, observation.RUN_ANGLE_BELOW_BASE, 1e-300)
        )
        .met
    )


K1 = convergence.SPEED_TOLERANCE


@pytest.mark.parametrize("check", ["CNV-1", "CPW-1"])
def test_speed_error_of_k1(rated_power: RunRecord, check: str) -> None:
    assert_limit(
        check,
        with_window(rated_power, SPEED_ERROR=K1 * (1 - 1e-6)),
        with_window(rated_power, SPEED_ERROR=K1 * (1 + 1e-6)),
    )


def test_spread_of_the_means_of_k2(rated_power: RunRecord) -> None:
    spread = convergence.POWER_TOLERANCE * 50.0
    inside = with_window(
        rated_power, CURRENT_SUM=50.0, MEAN_LOWEST=50.0, MEAN_HIGHEST=50.0 + spread * (1 - 1e-6)
    )
    beyond = with_window(
        rated_power, CURRENT_SUM=50.0, MEAN_LOWEST=50.0, MEAN_HIGHEST=50.0 + spread * (1 + 1e-6)
    )
    assert_limit("CNV-1", inside, beyond)


def test_movement_of_the_angle_by_one_degree(rated_power: RunRecord) -> None:
    degree = math.radians(1.0)
    inside = with_window(rated_power, ANGLE_LOWEST=0.5, ANGLE_HIGHEST=0.5 + degree * (1 - 1e-6))
    beyond = with_window(rated_power, ANGLE_LOWEST=0.5, ANGLE_HIGHEST=0.5 + degree * (1 + 1e-6))
    assert_limit("CNV-1", inside, beyond)


def test_two_percent_above_the_least_current_sum(rated_power: RunRecord) -> None:
    window = next(rated_power.windows())
    torque = float(window.values[observation.WINDOW_TORQUE])
    least = least_current_sum(rated_power.drive, 900.0 * RADIANS_PER_RPM, torque, 48.0).current_sum
    inside = with_window(rated_power, CURRENT_SUM=least * (1.02 - 1e-6))
    beyond = with_window(rated_power, CURRENT_SUM=least * (1.02 + 1e-6))
    assert_limit("CNV-2", inside, beyond)


def test_below_half_load_the_optimum_is_only_advised() -> None:
    record = _record(steady_scenario(MOTOR, 1000.0, power_share=0.45, constant_power=False))
    light = BY_ID["CNV-2"].evaluate(record)
    half = BY_ID["CNV-2"].evaluate(
        _record(steady_scenario(MOTOR, 1000.0, power_share=0.5, constant_power=False))
    )
    assert light is not None
    assert half is not None
    assert (light.advisory, half.advisory) == (True, False)


def test_ripple_on_both_sides_of_its_limit(published_point: RunRecord) -> None:
    """At 1500 rpm and 9.8 N·m a smaller inductance raises the ripple through 13 %."""
    ripples = {}
    for inductance in np.linspace(2.2e-3, 2.88e-3, 18):
        motor = MOTOR.with_overrides([f"inductance_h={inductance:.6g}"])
        scenario = published_point.scenario.replaced(motor=motor)
        margin = BY_ID["RIP-1"].evaluate(replace(published_point, scenario=scenario))
        assert margin is not None
        ripples[margin.value] = margin.met
    assert all(met == (value >= 0.0) for value, met in ripples.items())
    assert {True, False} == set(ripples.values()), f"the limit is not crossed: {sorted(ripples)}"


def test_repetitions_that_differ_in_one_bit(published_point: RunRecord) -> None:
    digest = published_point.run.digest
    same = replace(published_point, repeated_digests=(digest, digest))
    other = replace(published_point, repeated_digests=(digest, digest ^ 1))
    assert_limit("DET-1", same, other)
    assert BY_ID["DET-1"].evaluate(published_point) is None


def test_checks_tell_when_they_do_not_apply(through_base_speed: RunRecord) -> None:
    for check in ("CNV-1", "CNV-2", "CPW-1", "RIP-1"):
        assert BY_ID[check].evaluate(through_base_speed) is None, f"{check} applies to an unloaded run"


def test_declared_estimates_that_are_missing_fail(published_point: RunRecord) -> None:
    silent = with_run(published_point, observation.RUN_POWER_ESTIMATES, 0.0)
    margin = BY_ID["PWR-2"].evaluate(silent)
    assert margin is not None
    assert not margin.met
    undeclared = replace(silent, declaration=Declaration())
    assert BY_ID["PWR-2"].evaluate(undeclared) is None
