"""Every check is exercised by the runs that are said to exercise it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.declaration import Declaration
from drivegate.contracts.catalogue import all_contracts, contract_named
from drivegate.contracts.contract import Contract
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS, Family
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.traceability import (
    SPECIAL,
    families_of,
    family_name,
    traced_checks,
)
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.controllers.current.builtin import SEARCHES

DRIVE = load_drive("paper-5-phase")
FAMILIES = [family for group in FAMILY_GROUPS for family in group]
DRAWS = 8
APPLICABLE = {check.id for check in CHECKS if check.reason_not_applicable(Declaration(), DRIVE) is None}

Judged = Callable[[Scenario], set[str]]


@pytest.fixture(scope="module")
def judged() -> Judged:
    """Return the checks that a run of `initial`, which estimates its power, has margins of."""
    controller = BuiltinController(SEARCHES["initial"])

    def checks(scenario: Scenario) -> set[str]:
        record = CurrentRecord(scenario, run_scenario(scenario, controller), BUILTIN_CANDIDATES["initial"])
        return {margin.check for check in CHECKS if (margin := check.evaluate(record)) is not None}

    return checks


def test_every_family_has_its_row() -> None:
    assert [family_name(family.__name__) for family in FAMILIES] == list(contract_named("current").families)


def test_every_check_is_exercised() -> None:
    assert all(row["families"] for row in traced_checks(DRIVE))
    known = {check.id for check in CHECKS}
    assert {check for checks in SPECIAL.values() for check in checks} <= known


@pytest.mark.parametrize("contract", all_contracts(), ids=lambda contract: contract.name)
def test_a_check_judges_every_run_or_names_families_of_its_contract(
    contract: Contract,
) -> None:
    for check in contract.checks:
        assert not (check.every_run and check.families), check.id
        assert set(check.families) <= set(contract.families), f"{check.id} names {check.families}"


def test_the_fixed_scenarios_exercise_every_check_in_the_closed_loop(judged: Judged) -> None:
    seen = {check for scenario in fixed_scenarios(DRIVE) for check in judged(scenario)}
    assert seen == {check for check in APPLICABLE if families_of(check)[0] == "fixed"}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family_name(family.__name__))
def test_a_family_exercises_the_checks_that_it_is_there_for(family: Family, judged: Judged) -> None:
    name = family_name(family.__name__)
    listed = {check.id for check in CHECKS if check.every_run or name in check.families} & APPLICABLE
    draws: list[set[str]] = []

    def is_shown() -> bool:
        return bool(draws) and set.intersection(*draws) <= listed <= set().union(*draws)

    @seed(0)
    @settings(
        max_examples=DRAWS,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(family(DRIVE, None))
    def draw(scenario: Scenario) -> None:
        # Further runs would change nothing: they add to what is seen sometimes, and take from what always is.
        if not is_shown():
            draws.append(judged(scenario))

    draw()
    sometimes, always = set().union(*draws), set.intersection(*draws)
    assert listed <= sometimes, f"{listed - sometimes} are never exercised"
    assert always <= listed, f"{always - listed} are always exercised, but not listed"
