"""A fault in weakening does nothing on a drive that is never weakened, and the self-test states it."""

from __future__ import annotations

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS


def without_weakening(name: str = "pm-ac-surface") -> PmAcDocument:
    drive = load_drive(name)
    unweakened = drive.replaced(highest_speed_rpm=drive.rating.base_speed_rpm)
    assert isinstance(unweakened, PmAcDocument)
    return unweakened


DRIVE = without_weakening()


def test_a_fault_in_weakening_does_nothing_there() -> None:
    idle = {
        name: DUTY_FAULTS[name].on(DRIVE).idle_because for name in ("shallow-weakening", "stuck-weakening")
    }
    assert "without field weakening" in str(idle["shallow-weakening"])
    assert idle["stuck-weakening"] is None


def test_a_fault_that_costs_nothing_on_a_slow_drive_idles_there_alone() -> None:
    harmless = [name for name, fault in DUTY_FAULTS.items() if fault.harmless is not None]
    slow, fast = (
        {DUTY_FAULTS[name].on(load_drive(drive)).idle_because for name in harmless}
        for drive in ("pm-ac-hub", "pm-ac-interior")
    )
    assert fast == {None}
    assert slow == {
        None,
        "single precision counts each edge of the 2161 turns before a run; nightly has a million turns",
        "the drive needs no more weakening than the fault leaves",
        "the rotor turns by 3 degrees at most in a control period, for which its regulators make up",
    }


@pytest.mark.parametrize(
    ("drive", "reason"),
    [
        ("pm-ac-interior", None),
        ("pm-ac-hub", None),
        ("pm-ac-chopper", "the bridge lowers the rectifier's link by 1.7 V at most in a control period"),
    ],
)
def test_a_sag_is_noticed_where_the_link_follows_its_source(drive: str, reason: str | None) -> None:
    assert DUTY_FAULTS["sag-taken-for-short-circuit"].on(load_drive(drive)).idle_because == reason
