"""The fixed runs of operations that are rarely tried: their lengths on any drive."""

from __future__ import annotations

import pytest

from drivegate.contracts.duty.scenarios.rare import LONG_S, RARE, nightly_scenarios
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def _interior(carrier_hz: float) -> PmAcDocument:
    drive = load_drive("pm-ac-interior")
    assert isinstance(drive, PmAcDocument)
    inverter = drive.inverter.model_copy(update={"carrier_frequency_hz": carrier_hz})
    return drive.model_copy(update={"inverter": inverter})


@pytest.mark.parametrize(("carrier_hz", "share"), [(5e3, 1.0), (10e3, 1.0), (50e3, 0.2)])
def test_the_traces_of_a_long_run_stay_within_memory(carrier_hz: float, share: float) -> None:
    drive = _interior(carrier_hz)
    (run,) = RARE["minutes"](drive)
    assert run.duration_s == pytest.approx(share * LONG_S)
    assert run.duration_s / drive.control_period_s < 750_001, "some 300 bytes for each control period"
    for nightly in nightly_scenarios(drive, ("speed", "torque")):
        assert nightly.duration_s == pytest.approx(2.0 * share * LONG_S)
