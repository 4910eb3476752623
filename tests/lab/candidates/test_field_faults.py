"""Faults from the field are caught in the fixed runs of their kind, which the correct controller passes."""

from __future__ import annotations

from functools import cache

import pytest
from tests.lab.failed_checks import failed_checks

from drivegate.contracts.duty.scenarios.rare import RARE, RARE_BACKWARD
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.field_faults import FIELD_FAULTS
from drivegate_lab.selftest.operations import Operation, operations

INTERIOR, PAPER = load_drive("pm-ac-interior"), load_drive("paper-5-phase")
KINDS = {**RARE, **RARE_BACKWARD}


@cache
def runs_of(kind: str) -> tuple[Scenario, ...]:
    assert isinstance(INTERIOR, PmAcDocument)
    return tuple(KINDS[kind](INTERIOR))


@pytest.mark.one_in(6)
@cache
@pytest.mark.parametrize("name", FIELD_FAULTS)
def test_a_fault_from_the_field_is_caught_in_a_run_of_its_kind(name: str) -> None:
    fault = FIELD_FAULTS[name]
    showing = next(
        (run for run in runs_of(fault.kind) if fault.check in failed_checks(f"faulty:{name}", run)), None
    )
    assert showing is not None, f"no run of '{fault.kind}' fails {fault.check}"
    assert failed_checks("foc", showing) == frozenset()


FURTHER = [operation for operation in operations(INTERIOR) if operation.kind not in KINDS]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("operation", [*operations(PAPER), *FURTHER], ids=lambda operation: operation.kind)
def test_each_fault_of_an_operation_is_caught_in_a_run_of_its_kind(operation: Operation) -> None:
    for fault in operation.faults:
        caught = [
            run
            for run in operation.runs
            if fault.check in failed_checks(f"faulty:{fault.name}", run) - failed_checks(fault.base, run)
        ]
        assert caught, f"no run of '{operation.kind}' fails {fault.check} by {fault.name}"


def test_every_kind_of_operation_has_a_fault() -> None:
    assert {fault.kind for fault in FIELD_FAULTS.values()} == set(KINDS)
