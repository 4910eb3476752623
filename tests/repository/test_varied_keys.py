"""Every field of the contract and every key of a scenario varies, or there is a reason why it does not."""

import pytest
from pydantic import Field
from varied_keys import (
    JUDGED,
    NOT_VARIED,
    SENSED,
    Varied,
    document_keys,
    drawn_by_family,
    unvaried,
    varied_keys,
)

from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.signals import Command, Nameplate, Sense


@pytest.fixture(scope="module")
def varied() -> list[Varied]:
    return varied_keys(drawn_by_family(load_drive("paper-5-phase")))


def test_every_key_and_field_varies_or_has_its_reason(varied: list[Varied]) -> None:
    keys = [*document_keys(), *(f"nameplate {field}" for field in Nameplate._fields)]
    missing = unvaried(varied, keys)
    assert not missing, f"no family varies {missing}, and NOT_VARIED gives no reason"


def test_a_key_that_is_added_and_not_varied_is_found(varied: list[Varied]) -> None:
    class Extended(Scenario):
        humidity: float = Field(default=0.5)

    assert unvaried(varied, document_keys(Extended)) == ["humidity"]
    assert unvaried(varied, ["nameplate colour"]) == ["nameplate colour"]


def test_no_reason_is_given_for_what_varies_or_is_not_there(varied: list[Varied]) -> None:
    known = {row.key: row.families for row in varied}
    stale = [key for key in NOT_VARIED if known.get(key, ("unknown",)) and key not in ("name", "description")]
    assert not stale


def test_every_field_of_the_sense_is_reached_by_keys_that_vary(varied: list[Varied]) -> None:
    assert set(SENSED) == set(Sense._fields)
    families = {row.key: row.families for row in varied}
    for field, keys in SENSED.items():
        assert all(families[key] for key in keys), f"{field} depends on {keys}, of which one does not vary"


def test_every_field_of_the_command_is_judged() -> None:
    assert set(JUDGED) == set(Command._fields)
    assert {check for checks in JUDGED.values() for check in checks} <= {check.id for check in CHECKS}


@pytest.mark.parametrize(
    ("key", "lowest", "highest"),
    [
        ("control_period_s", 5e-5, 5e-4),
        ("speed_rpm", 0.0, 2000.0),
        ("duration_s", 12.0, 150.0),
        ("clock_start_s", 0.0, 4290.0),
        ("initial_angle_deg", 0.0, 300.0),
        ("current_errors.phase", 1, 5),
        ("load.factor", 0.0, 1.0),
    ],
)
def test_ranges_are_those_that_the_contract_leaves_free(
    varied: list[Varied], key: str, lowest: float, highest: float
) -> None:
    row = next(row for row in varied if row.key == key)
    assert float(row.values[0]) <= lowest, row
    assert float(row.values[1]) >= highest, row
