"""`drivegate new --sensorless`: a controller in C for a drive without a position sensor."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.duty.scenarios.sensorless import flying_start, sensorless_start
from drivegate.drives.kinds import drive_for
from drivegate.drives.running import recorded
from drivegate.studies.new import write_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

TODAY = datetime.now(UTC).date()
DRIVE = "pm-ac-2kw-sensorless"


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> CurrentRecord:
    return recorded(loaded, scenario, loaded.controller())


@pytest.mark.parametrize("kind", ["c", "embedded-coder"])
def test_it_starts_from_half_a_turn_and_takes_over_a_turning_shaft(kind: str, tmp_path: Path) -> None:
    write_candidate(kind, "mine", tmp_path / "mine", TODAY, DRIVE)
    candidate = resolve_candidate(str(tmp_path / "mine" / "candidate.toml"))
    drive = drive_for(candidate)
    assert isinstance(drive, PmAcDocument)
    assert drive.name == DRIVE
    start = sensorless_start(drive, drive.least_speed_rpm, 0.5, 180.0)
    with Judge(candidate) as judge:
        for run in (start, flying_start(drive, -0.5 * drive.rating.base_speed_rpm)):
            record = judge.run(Job(run_once, run))
            assert not isinstance(record, Fault), record
            reached = record.run.column("speed")[-400:].mean() / RADIANS_PER_RPM
            assert reached == pytest.approx(run.speed_rpm[-1][1], abs=0.02 * drive.rating.base_speed_rpm)
            margins = {m.check: m for m in judged(record, contract_of(drive).checks).margins}
            assert margins["OVC-1"].met, margins["OVC-1"].measured


def test_a_template_that_needs_an_angle_is_refused_for_a_drive_without_a_sensor(tmp_path: Path) -> None:
    with pytest.raises(
        InputError,
        match=r"'pm-ac-2kw-sensorless' has no position sensor, .* take c or embedded-coder, or name",
    ):
        write_candidate("numba", "mine", tmp_path / "mine", TODAY, DRIVE)


def test_the_option_is_refused_where_it_says_nothing(refused) -> None:
    sentence = refused("new", "c", "mine", "--drive", "pm-ac-2kw", "--sensorless")
    assert "for a drive without a position sensor, but 'pm-ac-2kw' has one" in sentence
    assert "goes with a candidate only" in refused("new", "scenario", "mine.toml", "--sensorless")


def test_the_option_names_a_drive(command, tmp_path: Path) -> None:
    ended = command("new", "c", "mine", "--sensorless", "--json")
    assert ended.code == 0
    assert f'drive = "{DRIVE}"' in (tmp_path / "mine" / "candidate.toml").read_text(encoding="utf-8")


def test_a_drive_file_without_a_sensor_has_the_same_sources(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(drive_toml(load_drive(DRIVE).replaced(name="own")), encoding="utf-8")
    write_candidate("c", "mine", tmp_path / "mine", TODAY, str(file))
    written = {path.name for path in (tmp_path / "mine").iterdir()}
    assert written >= {"sensorless.c", "regulators.c", "controller.c", "drive.toml"}
