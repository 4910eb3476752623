"""How much voltage a controller may reserve, judged on a controller that takes its link for lower than it is."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.harness.contracts.duty.checks.conftest import judged

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.fixed import release_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.faulty_duty_controller import PerturbedController
from drivegate_models.controllers.duty.reference_voltage import VOLTAGE_SHARE


@pytest.mark.parametrize(("reserved", "met"), [(0.04, True), (0.12, False)])
def test_a_controller_may_reserve_a_little_voltage_on_a_steep_machine(reserved: float, met: bool) -> None:
    """At the highest speed of this drive 4 % of the voltage are worth 7 % of the torque."""
    drive = load_drive("pm-ac-msl").replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    # The controller itself makes its references for `VOLTAGE_SHARE` of what it takes for the link.
    factor = (1.0 - reserved) / VOLTAGE_SHARE
    fault = replace(DUTY_FAULTS["torque-of-rms-currents"], changes={"supply_factor": factor})
    controller = PerturbedController(fault)
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, release_scenario(drive), controller)
    assert isinstance(record, DutyRecord)
    margin = judged("FWK-1", record)
    assert margin is not None
    assert margin.met is met, margin.measured
