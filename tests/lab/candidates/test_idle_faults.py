"""A fault in weakening does nothing on a drive that is never weakened, and the self-test states it."""

from __future__ import annotations

import math

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.field_faults import FIELD_FAULTS


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


@pytest.mark.parametrize(("drive", "is_idle"), [("pm-ac-interior", False), ("pm-ac-hub", True)])
def test_a_filter_of_the_link_shows_where_the_link_itself_steps(drive: str, is_idle: bool) -> None:
    idle = FIELD_FAULTS["link-filtered"].on(load_drive(drive)).idle_because
    assert (idle is not None) is is_idle, idle


def test_late_samples_cost_another_thing_without_saliency() -> None:
    fault = DUTY_FAULTS["late-samples"]
    checks = {name: fault.on(load_drive(name)).check for name in ("pm-ac-interior", "pm-ac-servo-48v")}
    assert checks == {"pm-ac-interior": "FWK-3", "pm-ac-servo-48v": "FWK-2"}


def test_a_model_of_the_winding_overheats_within_the_run_of_minutes() -> None:
    """At 20 kHz this run is 37.5 s long; rated torque, of which it has 90 %, overheats the model by half."""
    drive = load_drive("pm-ac-servo-48v")
    fault = FIELD_FAULTS["winding-modelled-too-small"]
    time_constant, _ = fault.sizes_on(drive.duty_nameplate(drive.control_period_s, torque_reference=False))
    hot_after = -time_constant * math.log(1.0 - 0.5 / 0.81)
    assert hot_after < 0.9 * 37.5
