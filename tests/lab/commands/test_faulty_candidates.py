"""A faulty controller runs by its name like any candidate, and a command reports what it does wrong."""

from __future__ import annotations

from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS


def test_duty_ratios_beyond_their_range_are_reported(command, tmp_path) -> None:
    drive = load_drive("pm-ac-interior").replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    case = tmp_path / "case.json"
    case.write_text(torque_scenario(drive, 1200.0, (0.5,)).to_json(), encoding="utf-8")
    name = next(name for name, fault in DUTY_FAULTS.items() if fault.check == "DUT-1")
    document = command("simulate", f"faulty:{name}", "--case", case, "--json").document
    assert any("duty ratios clipped to" in words for words in document["clamped"])
