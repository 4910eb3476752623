"""A controller whose torque swings the dc link is not excused by that swing."""

from __future__ import annotations

import numpy as np
from tests.harness.contracts.duty.checks.conftest import judged

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import restarted, share_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def test_a_torque_that_swings_its_own_link_is_judged() -> None:
    """A controller that takes currents for offsets swings the torque by so much that the link follows."""
    drive = load_drive("pm-ac-hub")
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate("faulty:offsets-under-current"))
    run = share_scenario(drive, 0.5 * drive.rating.base_speed_rpm, 0.6)
    record = recorded(loaded, restarted(run, (0.5,)), loaded.controller())
    assert isinstance(record, DutyRecord)
    (window,) = record.nominal
    link = record.run.column("link")[record.periods(window.start_s, window.end_s)]
    assert np.ptp(link) > 0.005 * drive.inverter.link_voltage_v
    margin = judged("RIP-4", record)
    assert margin is not None
    assert not margin.met, margin.measured
