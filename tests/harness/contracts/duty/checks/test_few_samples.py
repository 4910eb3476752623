"""With few samples in a cycle a machine has less torque between them, which is no fault of a controller."""

from __future__ import annotations

import pytest
from tests.harness.contracts.duty.checks.conftest import Run, judged

from drivegate.contracts.duty.checks.accuracy import lost_between_samples
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.fundamental import steady_state

SLOW = {"carrier_frequency_hz": 2500.0, "dead_time_s": 0.0, "switch_drop_v": 0.0, "diode_drop_v": 0.0}
"""An inverter whose control period is an eighth of a cycle at the greatest speed, and that is ideal otherwise."""


@pytest.mark.parametrize(
    ("speed_share", "torque_share", "lost"),
    [(1.0, 1.2, 0.0211), (1.4, 1.2, 0.0413), (1.4, -0.8, 0.0413)],
)
def test_torque_that_is_lost_between_samples_is_no_error(
    speed_share: float, torque_share: float, lost: float, run: Run
) -> None:
    drive = load_drive("pm-ac-servo").replaced(settling_s=0.8, **SLOW)
    assert isinstance(drive, PmAcDocument)
    record = run(share_scenario(drive, speed_share * drive.rating.base_speed_rpm, torque_share))
    (window,) = record.nominal
    assert lost_between_samples(record, window) == pytest.approx(lost, rel=0.01)
    sampled = steady_state(record.plant, window.speed, window.direct, window.quadrature).torque
    # What the resistance takes of the voltage turns as well, and gives some of the torque back.
    assert 0.85 * lost < 1.0 - window.torque / sampled < lost
    assert sampled == pytest.approx(window.torque_reference, rel=1e-3), "the controller holds what it samples"
    margin = judged("ACC-1", record)
    assert margin is not None
    assert margin.met, margin.measured
