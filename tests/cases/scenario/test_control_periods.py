"""Decimal times in documents are those of whole control periods where they are within rounding of them."""

from __future__ import annotations

import json
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.control_periods import (
    first_period_from,
    on_whole_periods,
    period_start_s,
    seen_at_s,
    whole_periods,
)
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

FREQUENCIES = (2000.0, 13e3, 15e3, 22e3, 30e3, 44.1e3, 97656.25, 200e3)
NUMBERS = (1, 2, 3, 7, 10, 4999, 50_001, 1_234_567)


@pytest.mark.parametrize("frequency", FREQUENCIES)
@pytest.mark.parametrize("number", NUMBERS)
def test_the_decimal_of_a_period_is_the_start_of_that_period(frequency: float, number: int) -> None:
    period = 1.0 / frequency
    for digits in (9, 8, 7):
        time = round(number * period, digits)
        assert whole_periods(time, period) == number
        assert first_period_from(time, period) == number
        assert seen_at_s(time, period) <= number * period
        assert on_whole_periods(time, period) == time
    assert whole_periods(period_start_s(number, period), period) == number


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_a_time_within_a_period_belongs_to_the_next(frequency: float) -> None:
    period = 1.0 / frequency
    time = 10.5 * period
    assert whole_periods(time, period) is None
    assert first_period_from(time, period) == 11
    assert seen_at_s(time, period) == time
    assert on_whole_periods(time, period) == period_start_s(11, period)


@pytest.mark.parametrize(
    ("period", "duration"),
    [
        (1 / 15e3, 10.0),
        (6.66666667e-5, 10.0),
        (1 / 22e3, 0.1),
        (4.545455e-5, 0.05),
        (5e-5, 0.3),
        (1 / 30e3, 0.0333333),
    ],
)
def test_a_sensible_decimal_duration_is_accepted_and_written_as_it_was(
    scenario_mapping: dict[str, Any], period: float, duration: float
) -> None:
    load = {"kind": "constant_torque", "torque_nm": 1.0, "factor": [[0, 0]]}
    mapping = scenario_mapping | {"control_period_s": period, "duration_s": duration, "load": load}
    run = parse_document(mapping, Scenario, "here")
    assert run.control_periods == round(duration / period)
    written = json.loads(run.to_json())
    assert (written["duration_s"], written["control_period_s"]) == (duration, period)
    assert parse_document(written, Scenario, "there") == run


def test_the_duration_that_a_message_suggests_is_accepted(scenario_mapping: dict[str, Any]) -> None:
    period = 1.0 / 22e3
    with pytest.raises(InputError, match="must be a whole number of control periods") as refused:
        parse_document(
            scenario_mapping | {"control_period_s": period, "duration_s": 1.00002}, Scenario, "here"
        )
    suggested = float(str(refused.value).rpartition("such as ")[2].rstrip("."))
    run = parse_document(
        scenario_mapping | {"control_period_s": period, "duration_s": suggested}, Scenario, "here"
    )
    assert run.control_periods == 22_000


def test_a_run_with_another_control_period_lasts_until_its_next_period(
    scenario_mapping: dict[str, Any],
) -> None:
    run = parse_document(scenario_mapping, Scenario, "here")
    assert run.replaced(control_period_s=1 / 15e3).duration_s == run.duration_s
    changed = run.replaced(control_period_s=3.6e-5)
    assert changed.control_periods == 27_778
    assert changed.duration_s == pytest.approx(27_778 * 3.6e-5, abs=1e-9)
