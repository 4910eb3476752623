"""Commands that know no duty ratios refuse PM AC drives in one sentence; the others take them."""

from __future__ import annotations

import pytest

from drivegate_cases.drive.drive_document import load_drive

DRIVE = ("--drive", "pm-ac-surface")


@pytest.mark.parametrize(
    "arguments",
    [
        ("compare", "foc", "foc-mtpa", *DRIVE, "--drive", "pm-ac-interior"),
        ("point", "--speed-rpm", "100", "--advance-deg", "0", "--torque-nm", "1", *DRIVE),
        ("map", "--speed-rpm", "100:200:2", "--torque-nm", "1", *DRIVE),
        ("new", "c", "mine", *DRIVE),
        ("selftest", *DRIVE),
    ],
)
def test_a_command_that_asks_for_an_advance_angle_refuses_them(arguments: tuple[str, ...], refused) -> None:  # type: ignore[no-untyped-def]
    assert "a drive of the kind 'pm-ac' is taken by drivegate check" in refused(*arguments)


def test_a_new_drive_begins_as_one_of_them(command, tmp_path) -> None:  # type: ignore[no-untyped-def]
    assert command("new", "drive", "mine.toml", *DRIVE).code == 0
    written = load_drive(str(tmp_path / "mine.toml"))
    assert written.kind == "pm-ac"
    assert written.machine == load_drive("pm-ac-surface").machine


def test_controllers_of_duty_ratios_are_compared_on_one_drive(command, tmp_path) -> None:  # type: ignore[no-untyped-def]
    names = ("foc", "foc-loss-model")
    made = command(
        "compare", *names, *DRIVE, "--effort", "quick", "--no-checks", "--workers", "1", "--output", "made"
    )
    assert made.code == 0, made.err
    assert made.out.index("foc-loss-model") < made.out.index(" foc "), "the one that loses less is first"
    written = (tmp_path / "made" / "comparison.html").read_text(encoding="utf-8")
    assert "foc-loss-model is first on pm-ac-surface" in written
    assert (tmp_path / "made" / "tables" / "operating_points.csv").is_file()
