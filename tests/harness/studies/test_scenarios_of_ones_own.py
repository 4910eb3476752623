"""Scenarios for PM AC drives that are included or newly written: fair, and met by the built-in controller."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.running import recorded
from drivegate.studies.new_scenario import scenario_toml, write_scenario
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.scenario.scenario import Scenario, load_scenario, scenario_names
from drivegate_models.errors import InputError

JUDGED = {
    "pm-ac-torque-step": {"STP-1", "ACC-1"},
    "pm-ac-speed-step": {"ROB-4", "ACC-1"},
    "pm-ac-weakening-and-release": {"FWK-1", "FWK-3"},
    "pm-ac-reversal": {"ROB-4", "ACC-1"},
    "pm-ac-start": {"STA-1"},
}


def test_five_cases_are_for_pm_ac_drives() -> None:
    assert {name for name in scenario_names() if load_scenario(name).drive.kind == "pm-ac"} == set(JUDGED)


@pytest.mark.parametrize("name", JUDGED)
def test_a_case_is_fair_judged_by_what_it_shows_and_met(name: str) -> None:
    run = load_scenario(name)
    assert run.name == name
    contract = contract_of(run.drive)
    assert contract.unfair_because(run) is None
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, run, loaded.controller())
    margins = {
        check.id: margin for check in contract.checks if (margin := check.evaluate(record)) is not None
    }
    assert set(margins) >= JUDGED[name]
    assert {check: margin.measured for check, margin in margins.items() if not margin.met} == {}


@pytest.mark.parametrize("drive", drive_names())
def test_a_new_scenario_is_one_of_its_drive(drive: str, tmp_path: Path) -> None:
    file = tmp_path / "my-run.toml"
    write_scenario(file, load_drive(drive), drive)
    run = load_scenario(file)
    assert (run.name, run.drive) == ("my-run", load_drive(drive))
    assert len(run.load_profile if run.drive.contract == "current" else run.torque_reference_profile) == 5
    with pytest.raises(InputError, match="nothing is ever overwritten"):
        write_scenario(file, load_drive(drive), drive)


def test_a_new_scenario_explains_every_key_that_its_drive_can_have() -> None:
    drive = load_drive("pm-ac-interior")
    text = scenario_toml("my-run", drive, drive.name)
    missing = {"supply_v", "imbalance", "control_period_s", "current_errors", "schema_version"}
    assert {key for key in Scenario.model_fields if f"{key} =" not in text} == missing | {"load"}
    assert "[load]" in text
