"""Checks of duty ratios accuse no correct controller on drives drawn at random."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import Run, judged

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import (
    torque_of,
    torque_scenario,
)
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument

DRIVES = Path(__file__).parent / "drives"
"""Drives that were drawn within earlier bounds, and showed what these tests are of."""


@pytest.fixture(scope="session")
def slow(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a torque at 8 % of base speed, which is also run with another dead time."""
    speed = 0.08 * interior.rating.base_speed_rpm
    return run(torque_scenario(interior, speed, (torque_of(interior, speed, 0.5),)))


@pytest.mark.parametrize(
    ("drive", "candidate", "speed_rpm", "torques_nm"),
    [
        # For seven periods the third phase carries nothing.
        (load_drive("pm-ac-surface"), "predictive-flux", 1100.0, (-6.077, 2.431)),
        # The voltage needs 110 periods for this step, for 40 of which the third phase carries nothing.
        (load_drive(DRIVES / "drawn-pm-ac-0-004.toml"), "foc", 780.0, (-1.6, 0.6)),
    ],
    ids=["short", "long"],
)
def test_a_phase_without_current_during_a_step_is_not_missing(
    drive: DriveDocument, candidate: str, speed_rpm: float, torques_nm: tuple[float, float]
) -> None:
    """At high speed the current vector stands while it shrinks."""
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate(candidate))
    record = recorded(loaded, torque_scenario(drive, speed_rpm, torques_nm), loaded.controller())
    assert isinstance(record, DutyRecord)
    assert not np.any(record.run.commands["fault"])


@pytest.mark.parametrize(
    ("number", "name"),
    [
        # The regulator of a slowly sampled drive needs 120 ms to reach the greatest torque.
        (1, "0-to-304rpm-91.72Nm-locked-rotor"),
        # The diodes of the open leg carry up to 90 % of the expected amplitude, for half of each turn.
        (17, "1440rpm-torque-28.78Nm-open-phase-1"),
    ],
    ids=["slow regulator", "diodes carry current"],
)
def test_foc_reaches_its_safe_state_in_time_on_drives_that_nobody_chose(number: int, name: str) -> None:
    drive = load_drive(DRIVES / f"drawn-pm-ac-0-{number:03d}.toml")
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate("foc"))
    runs = fixed_scenarios(drive, detected=frozenset({"locked-rotor", "open-phase"}))
    (scenario,) = (run for run in runs if run.name == name)
    margin = judged("SAF-1", recorded(loaded, scenario, loaded.controller()))
    assert margin is not None
    assert margin.met, margin.measured
