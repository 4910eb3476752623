"""LNK-1 to LNK-4: a link with a capacitor, on both sides of each limit, and runs in which nothing is judged."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged, with_column, with_command
from tests.harness.contracts.reading import is_read, read_off

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.duty.checks.link import swing_of
from drivegate.contracts.duty.scenarios.building import failing, restarted, share_scenario
from drivegate.contracts.duty.scenarios.linked import linked_scenarios, unfair_supply
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import LEG_LOW

NAMES = ("LNK-1", "LNK-2", "LNK-3", "LNK-4")


@pytest.fixture(scope="module")
def servo() -> PmAcDocument:
    drive = load_drive("pm-ac-servo-48v").replaced(settling_s=0.15)
    assert isinstance(drive, PmAcDocument)
    return drive


@pytest.fixture(scope="module")
def braking(servo: PmAcDocument) -> Scenario:
    return share_scenario(servo, 3000.0, 0.5, -1.0)


def test_foc_passes_all_four(braking: Scenario, run: Run) -> None:
    margins = [judged(check, run(braking)) for check in NAMES]
    assert all(margin is not None and margin.met for margin in margins), margins


@pytest.mark.parametrize(
    ("check", "column", "change", "is_met"),
    [
        ("LNK-1", "link_highest", lambda values: np.minimum(values, 59.9), True),
        ("LNK-1", "link_highest", lambda values: values + 0.0 * values + 60.1 - values.max(), False),
        ("LNK-2", "source_current", lambda values: 0.0 * values + 7.6, True),
        ("LNK-2", "source_current", lambda values: 0.0 * values + 7.7, False),
        ("LNK-3", "torque", lambda values: 0.9 * values, True),
        ("LNK-3", "torque", lambda values: 0.3 * values, False),
        ("LNK-4", "link_mean", lambda values: 50.0 + 0.45 * (-1.0) ** np.arange(len(values)), True),
        ("LNK-4", "link_mean", lambda values: 50.0 + 0.5 * (-1.0) ** np.arange(len(values)), False),
        ("LNK-4", "link_mean", lambda values: np.linspace(48.0, 56.0, len(values)), True),
    ],
)
def test_each_limit_has_two_sides(
    check: str, column: str, change: Any, is_met: bool, braking: Scenario, run: Run
) -> None:
    margin = judged(check, with_column(run(braking), column, change))
    assert margin is not None
    assert margin.met is is_met, margin.measured


@pytest.mark.parametrize(
    ("check", "column", "change"),
    [
        ("LNK-1", "link_highest", lambda values: values + 60.1 - values.max()),
        (
            "LNK-2",
            "source_current",
            lambda values: values + 8.0 * (np.abs(np.arange(len(values)) - 2000) < 300),
        ),
        ("LNK-4", "link_mean", lambda values: 50.0 + 0.5 * (-1.0) ** np.arange(len(values))),
    ],
)
def test_the_stated_value_can_be_read_off_the_figure(
    check: str, column: str, change: Any, braking: Scenario, run: Run
) -> None:
    measured, numbers = read_off(CHECKS[check], with_column(run(braking), column, change))
    assert is_read(measured, numbers), f"{measured!r} is not among {numbers}"


@given(st.lists(st.floats(0.0, 100.0), min_size=1, max_size=7))
def test_a_swing_is_the_most_that_three_voltages_in_a_row_go_away_and_back(voltages: list[float]) -> None:
    turns = (
        min(abs(second - first), abs(second - third))
        for first, second, third in combinations(voltages, 3)
        if max(first, third) < second or second < min(first, third)
    )
    assert swing_of(np.array(voltages)) == max(turns, default=0.0)


def test_a_source_with_an_inductance_exceeds_its_voltage_as_it_comes_back(
    servo: PmAcDocument, run: Run
) -> None:
    ringing = servo.replaced(source_inductance_h=1e-5)
    assert isinstance(ringing, PmAcDocument)
    lost = linked_scenarios(ringing)[-1]
    record = run(lost)
    assert 48.5 < record.run.column("link_highest").max() < 48.0 + 0.163 * 43.2
    margins = [judged(check, record) for check in NAMES]
    assert all(margin is None or margin.met for margin in margins), margins
    assert record.run.worst_balance < 1e-9


def test_no_run_is_fair_in_which_the_source_alone_exceeds_the_limit(servo: PmAcDocument) -> None:
    fair, ringing = servo, servo.replaced(source_inductance_h=1e-4)
    assert isinstance(ringing, PmAcDocument)
    lost = linked_scenarios(fair)[-1]
    assert lost.supply_v is not None
    assert unfair_supply(lost) is None
    assert "with the source's inductance" in (unfair_supply(lost.replaced(drive=ringing)) or "")
    assert len(linked_scenarios(ringing)) == len(linked_scenarios(fair)) - 1


def test_a_chopper_that_burns_may_let_the_link_swing(braking: Scenario, run: Run) -> None:
    record = with_column(run(braking), "chopper_power", lambda values: 0.0 * values + 1.0)
    assert judged("LNK-4", record) is None


def test_a_moment_of_much_current_is_no_mean(braking: Scenario, run: Run) -> None:
    def shot(values: Any) -> Any:
        values = 0.0 * values + 7.0
        values[100:103] = 15.0
        return values

    margin = judged("LNK-2", with_column(run(braking), "source_current", shot))
    assert margin is not None
    assert margin.met


def test_nothing_is_judged_on_an_ideal_link_and_after_a_restart(
    interior: PmAcDocument, braking: Scenario, run: Run
) -> None:
    records = [run(share_scenario(interior, 1000.0, 0.5)), run(restarted(braking, (0.5,)))]
    assert all(judged(check, record) is None for check in NAMES for record in records)
    assert "link is ideal" in str(CHECKS["LNK-1"].reason_not_applicable(Declaration(), interior))
    assert CHECKS["LNK-1"].reason_not_applicable(Declaration(), braking.drive) is None
    assert linked_scenarios(interior) == []


def test_what_the_diodes_charge_before_the_first_answer_is_not_judged(braking: Scenario, run: Run) -> None:
    def charged(values: Any) -> Any:
        values[:3] = 70.0
        return values

    def charged_later(values: Any) -> Any:
        values[5] = 70.0
        return values

    margins = [
        judged("LNK-1", with_column(run(braking), "link_highest", change))
        for change in (charged, charged_later)
    ]
    assert [margin is not None and margin.met for margin in margins] == [True, False]


def test_above_the_limit_of_the_link_a_short_circuit_is_the_safe_state(servo: PmAcDocument, run: Run) -> None:
    failing_run = failing(share_scenario(servo, 4000.0, 0.5), "open-phase", 0.1)
    record = run(failing_run)
    begin = round(0.1 / servo.control_period_s)
    legs = ("first_leg", "second_leg", "third_leg")

    def short(values: Any) -> Any:
        values[begin:] = LEG_LOW
        return values

    for leg in legs:
        record = with_command(record, leg, short)
    record = with_command(record, "fault", lambda values: 0 * values)
    record = with_column(
        record, "torque", lambda values: np.where(np.arange(len(values)) <= begin, values, -0.2)
    )
    taken = judged("SAF-1", record)
    assert taken is not None
    assert not taken.met, "the EMF is below the limit of the link, where all legs off are safe"
    fast = with_column(record, "speed", lambda values: 4.0 * values)
    margin = judged("SAF-1", fast)
    assert margin is not None
    assert margin.met, margin.measured
