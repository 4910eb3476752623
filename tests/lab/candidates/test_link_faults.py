"""Controllers that ask too much of a dc link, or too little, are caught by the checks that are named for them."""

from __future__ import annotations

from functools import cache

import pytest
from tests.lab.failed_checks import failed_checks

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.informed import InformedController
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.linked import linked_scenarios
from drivegate.drives.running import recorded
from drivegate.gate.witness_runs import judged_witness, witnesses_for
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS

DRIVES = {
    **{name: load_drive(name) for name in ("pm-ac-servo-48v", "pm-ac-chopper", "pm-ac-hub")},
    "saturated": load_drive("pm-ac-chopper").replaced(chopper_resistance_ohm=400.0),
    "weak": load_drive("pm-ac-hub").replaced(discharge_limit_a=8.0),
}
CASES = [
    (drive, name)
    for drive in DRIVES
    for name, fault in DUTY_FAULTS.items()
    if fault.check.startswith("LNK-") and fault.on(DRIVES[drive]).idle_because is None
]


@cache
def failed(drive_name: str, candidate: str) -> frozenset[str]:
    """Return the checks that a candidate fails in the runs that strain a link."""
    drive = DRIVES[drive_name].replaced(settling_s=0.2)
    assert isinstance(drive, PmAcDocument)
    # Braking that the current limit leaves some current to burn for.
    slight = share_scenario(drive, 0.3 * drive.rating.base_speed_rpm, 0.0, -0.6, -1.0)
    return failed_checks(candidate, *linked_scenarios(drive), slight)


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("drive", "name"), CASES)
def test_each_is_caught_by_the_check_that_is_named_for_it(drive: str, name: str) -> None:
    assert DUTY_FAULTS[name].check in failed(drive, f"faulty:{name}")


@pytest.mark.one_in(2)
@pytest.mark.parametrize("drive", ["pm-ac-servo-48v", "pm-ac-chopper", "pm-ac-hub"])
@pytest.mark.parametrize("name", ["foc", "load-observer"])
def test_no_controller_that_heeds_the_link_is_accused(drive: str, name: str) -> None:
    assert failed(drive, name) == frozenset()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("drive", ["pm-ac-servo-48v", "pm-ac-chopper", "pm-ac-hub"])
def test_a_link_regulator_of_another_design_meets_every_check_of_the_link(drive: str) -> None:
    # The other witnesses share one; this takes its currents from the steady states that the oracle of the link allows.
    short = DRIVES[drive].replaced(settling_s=0.15)
    assert isinstance(short, PmAcDocument)
    witness = next(each for each in witnesses_for(short) if each.made_for is InformedController)
    checks = [check for check in contract_of(short).checks if check.id.startswith("LNK-")]
    for scenario in linked_scenarios(short):
        loaded = judged_witness(witness, scenario, NOTHING_DECLARED)
        record = recorded(loaded, scenario, loaded.controller())
        margins = [margin for check in checks if (margin := check.evaluate(record)) is not None]
        assert len(margins) >= 3
        assert all(margin.met for margin in margins), margins


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("drive", "name"),
    [
        ("pm-ac-hub", "sag-taken-for-short-circuit"),
        ("pm-ac-hub", "reference-missed-with-link"),
        ("pm-ac-chopper", "reference-missed-with-link"),
    ],
)
def test_a_link_that_follows_its_source_slowly_changes_with_the_reference(drive: str, name: str) -> None:
    linked = DRIVES[drive].replaced(settling_s=0.2)
    assert isinstance(linked, PmAcDocument)
    runs = [run for run in fixed_scenarios(linked, ("torque",)) if run.supply_v and "-torque-" in run.name]
    assert DUTY_FAULTS[name].check in failed_checks(f"faulty:{name}", *runs)
    assert failed_checks("foc", *runs) == frozenset()
