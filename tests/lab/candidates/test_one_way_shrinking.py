"""A counterexample of a candidate that turns one way is shrunk to none that needs reverse."""

from __future__ import annotations

from dataclasses import replace

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.gate.shrinking import ShrinkPlan, run_shrink
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument

DRIVE = load_drive("pm-ac-interior").replaced(settling_s=0.1)
assert isinstance(DRIVE, PmAcDocument)


@pytest.mark.parametrize("reverses", [True, False])
def test_shrinking_asks_for_no_reverse_either(reverses: bool) -> None:
    weak = resolve_candidate("faulty:weak-braking")
    loaded = own_candidate(replace(weak, declaration=replace(weak.declaration, reverses=reverses)))
    braking = torque_scenario(DRIVE, 300.0, (-DRIVE.rating.rated_torque_nm,))
    shrunk = run_shrink(loaded, ShrinkPlan(braking.to_mapping(), "ACC-1", budget=6))
    assert shrunk is not None
    speeds = {speed for _, speed in shrunk.scenario["speed_rpm"]}
    assert (speeds == {0.0}) is reverses, speeds
