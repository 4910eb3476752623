"""What is answered to mistakes that people make: the unit, the quotes, the name or the drive that was meant."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from drivegate_cases.drive.drive_document import included_drives, is_included, load_drive
from drivegate_cases.drive.drive_file import drive_toml

THERMAL = "\n[thermal]\nheat_capacity_j_per_k = 50.0\nthermal_resistance_k_per_w = 2.0\nlimit_c = 120.0\n"


@pytest.fixture
def servo() -> str:
    """Return the file of a drive with a link, without its comments."""
    return drive_toml(load_drive("pm-ac-servo-48v"))


@pytest.mark.parametrize(
    ("before", "after", "answer"),
    [
        (
            "capacitance_f = 0.001",
            "capacitance_f = 1000.0",
            "must be at most 10: in farads, 1000 µF are 0.001",
        ),
        (
            "",
            f"{THERMAL}temperature_coefficient_per_k = 0.393\n",
            "of copper it is 0.00393, which is 0.393 %",
        ),
        (
            "",
            f"{THERMAL}time_constant_min = 6.0\n",
            "divide the windings' time constant in seconds by thermal_resistance",
        ),
        ("", "\n[sensing]\nposition = none\n", 'a text has no quotes; write position = "none"'),
    ],
)
def test_a_value_in_another_unit_or_without_quotes_is_answered_with_the_right_one(
    before: str, after: str, answer: str, servo: str, refused: Any, tmp_path: Path
) -> None:
    assert before in servo
    (tmp_path / "mine.toml").write_text(servo.replace(before, after, 1) if before else servo + after)
    assert answer in refused("drive", "mine.toml")


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (("drive", "pm-ac-2kw-sensorles"), "the nearest is 'pm-ac-2kw-sensorless'"),
        (
            ("drive", "paper-5-phase-sensorless"),
            "no variant without a position sensor, as PM AC drives have one",
        ),
        (
            ("drive", "paper-5-phase", "--set", "sensing.position=none"),
            "the key 'sensing.position' is unknown, and no known key resembles it",
        ),
        (("check", "foc", "--max-time", "5min"), "must be a number of seconds above 0"),
        (("report", "."), ". is a folder; name a TOML or JSON file in it"),
    ],
)
def test_the_name_or_unit_that_was_meant_is_stated(words: tuple[str, ...], answer: str, refused: Any) -> None:
    assert answer in refused(*words)


def test_a_drive_in_place_of_a_result_is_called_one(servo: str, refused: Any, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(servo)
    assert "mine.toml is the file of a drive, but must be" in refused("verify", "mine.toml")


def test_a_check_of_other_drives_is_explained_with_one_of_them(command: Any) -> None:
    row = command("checks", "SLS-1", "--json").document["checks"][0]
    assert row["applies_on"] in included_drives()
    text = command("explain", "SLS-1").out
    assert "not applicable on pm-ac-interior: the drive has a position sensor" in text
    assert f"next: drivegate check CANDIDATE --only SLS-1 --drive {row['applies_on']}" in text
    applies = command("checks", "STP-1", "--json").document["checks"][0]
    assert (applies["not_applicable"], applies["applies_on"]) == (None, None)


def test_a_drive_without_its_sensor_is_named_in_new_files(
    command: Callable[..., Any], tmp_path: Path
) -> None:
    name = "pm-ac-2kw-sensorless"
    assert is_included(name)
    assert not is_included("paper-5-phase-sensorless")
    scenario = command("new", "scenario", "run.toml", "--drive", name)
    assert "drivegate simulate foc-sensorless --case run.toml" in scenario.out
    assert tomllib.loads((tmp_path / "run.toml").read_text())["drive"] == name
    assert command("new", "C", "mine", "--drive", name).code == 0
    assert tomllib.loads((tmp_path / "mine" / "candidate.toml").read_text())["drive"] == name
