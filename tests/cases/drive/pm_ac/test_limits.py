"""What controllers of duty ratios are judged by, where a drive's file leaves it out."""

from __future__ import annotations

from typing import Any, cast

import pytest

from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.drive.limits import Limits, limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.requirements import NO_PM_AC_REQUIREMENTS

DRIVES = [drive for name in drive_names() if isinstance(drive := load_drive(name), PmAcDocument)]
INTERIOR = next(drive for drive in DRIVES if drive.name == "pm-ac-interior")


def limits(**changes: Any) -> Limits:
    return limits_of(INTERIOR.replaced(**changes))


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: drive.name)
def test_packaged_drives_state_the_usual_rise_time_and_leave_up_to_100_ms_to_the_safe_state(
    drive: PmAcDocument,
) -> None:
    assert drive.requirements.rise_periods == NO_PM_AC_REQUIREMENTS.rise_periods
    found = limits_of(drive)
    allowed = pytest.approx(min(0.1, 1000 * drive.control_period_s))
    assert (found.safe_state_s, found.safe_state_locked_s) == (allowed, allowed)


def test_the_safe_state_follows_the_time_scales_of_the_drive() -> None:
    fast = limits(carrier_frequency_hz=50e3, base_speed_rpm=5000.0, inertia_kg_m2=1e-5)
    assert fast.safe_state_s == pytest.approx(1000 * 2e-5), "1000 control periods"
    assert fast.safe_state_locked_s == pytest.approx(1000 * 2e-5)
    slow = limits(base_speed_rpm=300.0)
    turn = 60.0 / (INTERIOR.machine.pole_pairs * 0.2 * 300.0)
    assert slow.safe_state_s == pytest.approx(100 * 1e-4 + 0.5 * turn), "half a turn of the field"
    heavy = limits(inertia_kg_m2=0.02)
    base = INTERIOR.rating.base_speed_rpm * 3.141592653589793 / 30.0
    run_up = 0.02 * base * base / INTERIOR.rating.rated_power_w
    assert heavy.safe_state_locked_s == pytest.approx(100 * 1e-4 + 0.2 * run_up), "a fifth of the run-up"
    assert heavy.safe_state_s == 0.1, "a phase does not wait for the shaft"


def test_a_light_rotor_is_locked_once_a_speed_regulator_has_raised_its_torque() -> None:
    base = INTERIOR.rating.base_speed_rpm * 3.141592653589793 / 30.0
    torque, rate = INTERIOR.rating.rated_power_w / base, 0.02 / 1e-4
    light = limits(inertia_kg_m2=0.5 * torque / (rate * base))
    raised = 4.0 / rate * (1.2 / 0.5 - 1.0)
    assert light.safe_state_locked_s == pytest.approx(0.1 + raised), "J b w is half of rated torque"
    assert light.safe_state_s == 0.1, "a phase does not wait for the torque"
    enough = limits(inertia_kg_m2=1.2 * torque / (rate * base))
    assert enough.safe_state_locked_s == pytest.approx(0.1), "J b w is more than any load"


def test_a_stated_time_to_the_safe_state_is_taken_as_it_is() -> None:
    for base in (300.0, 2100.0):
        found = limits(safe_state_ms=20.0, base_speed_rpm=base)
        assert (found.safe_state_s, found.safe_state_locked_s) == (0.02, 0.02)


def test_a_locked_shaft_looks_like_one_that_starts_until_that_one_must_have_passed_a_sector() -> None:
    hall = limits_of(cast(PmAcDocument, INTERIOR.with_overrides(["sensing.position=hall"])))
    base = INTERIOR.rating.base_speed_rpm * 3.141592653589793 / 30.0
    torque = INTERIOR.rating.rated_power_w / base
    inertia, sector = INTERIOR.machine.inertia_kg_m2, 3.141592653589793 / 3.0 / INTERIOR.machine.pole_pairs
    passed = (2.0 * sector * inertia / (0.1 * torque)) ** 0.5
    assert hall.safe_state_locked_s == pytest.approx(0.01 + 0.2 * inertia * base / torque + passed)
    assert hall.safe_state_s == limits().safe_state_s
    encoder = limits_of(cast(PmAcDocument, INTERIOR.with_overrides(["sensing.position=encoder"])))
    assert encoder.safe_state_locked_s == limits().safe_state_locked_s
