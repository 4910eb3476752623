"""A drive as a data sheet states it: wrong poles and terminal values are seen, and asked about where they show."""

from __future__ import annotations

import pytest

from drivegate.drives.sheet_values import doubtful_values, sheet_in_words, sheet_values
from drivegate_cases.drive.drive_document import DriveDocument, drive_names, load_drive

SERVO = load_drive("pm-ac-servo")


def doubts(drive: DriveDocument, *, is_refused: bool = False) -> str:
    return " ".join(doubtful_values(drive, is_refused=is_refused, accepts=lambda _: is_refused))


def test_values_are_those_that_a_data_sheet_prints() -> None:
    """8 poles, 0.4212 N·m a dc ampere, which is 60 / (2 π 0.4212) rpm/V, and twice 2.303 Ω between terminals."""
    words = sheet_in_words(sheet_values(SERVO), SERVO.machine.pole_pairs)
    assert words == (
        "link 300 V, 8 poles (pole_pairs = 4), Kv 22.67 rpm/V, Kt 0.4212 N·m/A, 4.606 Ω between terminals, "
        "stall torque 27.44 N·m"
    )
    values = sheet_values(SERVO)
    assert values["stall_torque_nm"] == pytest.approx(
        values["torque_constant_nm_per_a"] * 300.0 / values["terminal_resistance_ohm"]
    )
    block = load_drive("star-24v-3-phase")
    assert sheet_values(block)["torque_constant_nm_per_a"] == pytest.approx(0.035)


@pytest.mark.parametrize("name", drive_names())
def test_included_drives_raise_no_doubt(name: str) -> None:
    drive = load_drive(name)
    assert doubts(drive) == ""
    assert "poles (pole_pairs = " in sheet_in_words(sheet_values(drive), drive.machine.pole_pairs)


def test_poles_taken_for_pairs_are_asked_about() -> None:
    doubled = SERVO.replaced(pole_pairs=2 * SERVO.machine.pole_pairs)
    assert "pole_pairs is 8, which are 16 poles: does the data sheet state 8 poles?" in doubts(doubled)
    odd = SERVO.replaced(pole_pairs=21)
    assert "poles" not in doubts(odd), "half of an odd number of poles is no number of pairs"


def test_terminal_values_taken_for_those_of_a_phase_are_asked_about() -> None:
    drive = load_drive("star-24v-3-phase")
    doubled = drive.replaced(
        resistance_ohm=2.0 * drive.machine.resistance_ohm, inductance_h=2.0 * drive.value("inductance_h")
    )
    words = doubts(doubled)
    assert "between terminals? Then write half of them: resistance_ohm = 0.75, inductance_h = " in words
    assert "resistance and inductance between terminals" in doubts(SERVO, is_refused=True)


@pytest.mark.parametrize(("key", "value"), [("resistance_ohm", 2.0e3), ("direct_inductance_h", 5.0)])
def test_half_of_a_value_in_another_unit_is_not_advised(key: str, value: float) -> None:
    assert "terminals" not in doubts(SERVO.replaced(**{key: value}), is_refused=True)
