"""Commands that know no duty ratios refuse PM AC drives in one sentence; the others take them."""

from __future__ import annotations

import pytest

from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument

DRIVE = ("--drive", "pm-ac-surface")


@pytest.mark.parametrize(
    "arguments",
    [
        ("point", "--speed-rpm", "100", "--advance-deg", "0", "--torque-nm", "1", *DRIVE),
        ("map", "--speed-rpm", "100:200:2", "--torque-nm", "1", *DRIVE),
    ],
)
def test_a_command_that_asks_for_an_advance_angle_refuses_them(arguments: tuple[str, ...], refused) -> None:
    stated = refused(*arguments)
    assert "a drive of the kind 'pm-ac' has no steady states of an advance angle" in stated
    assert "drivegate drive shows what it can do" in stated


def test_a_new_drive_begins_as_one_of_them(command, tmp_path) -> None:
    assert command("new", "drive", "mine.toml", *DRIVE).code == 0
    written = load_drive(str(tmp_path / "mine.toml"))
    assert written.kind == "pm-ac"
    assert written.machine == load_drive("pm-ac-surface").machine


def test_controllers_of_duty_ratios_are_compared_on_one_drive(command, undrawn, tmp_path) -> None:
    names = ("foc", "foc-loss-model")
    made = command(
        "compare", *names, *DRIVE, "--effort", "quick", "--no-checks", "--workers", "1", "--output", "made"
    )
    assert made.code == 0, made.err
    assert made.out.index("foc-loss-model") < made.out.index(" foc "), "the one that loses less is first"
    written = (tmp_path / "made" / "comparison.html").read_text(encoding="utf-8")
    assert "foc-loss-model ranks first on pm-ac-surface" in written
    assert (tmp_path / "made" / "tables" / "operating_points.csv").is_file()


def test_controllers_of_duty_ratios_are_compared_across_drives(command, undrawn, tmp_path) -> None:
    for name in ("pm-ac-surface", "pm-ac-interior"):
        brief = load_drive(name).replaced(settling_s=0.1)
        (tmp_path / f"{name}.json").write_text(brief.to_json(), encoding="utf-8")
    drives = ("--drive", "pm-ac-surface.json", "--drive", "pm-ac-interior.json")
    brief = ("--effort", "quick", "--no-checks", "--workers", "1")
    document = command("compare", "foc", *drives, *brief, "--output", "made", "--json").document
    assert document["kind"] == "drive-comparison"
    surface, interior = document["tables"]["summary"]
    assert (surface["drive"], interior["drive"]) == ("pm-ac-surface", "pm-ac-interior")
    for row in (surface, interior):
        assert row["points_held"] == row["points"] == row["points_shared"] == 15
        assert 85.0 < row["efficiency_percent"] < 95.0
    assert [part["kind"] for part in document["parts"]] == ["duty-comparison"] * 2
    written = (tmp_path / "made" / "drive-comparison.html").read_text(encoding="utf-8")
    assert "pm-ac-surface and pm-ac-interior under the same controllers" in written
    assert (tmp_path / "made" / "drive-2" / "comparison.html").is_file()


def test_drives_that_no_one_controller_runs_on_are_not_compared(refused) -> None:
    stated = refused("compare", "foc", *DRIVE, "--drive", "star-3-phase")
    assert "no one controller runs on both" in stated
    assert "drivegate reproduce" in stated


@pytest.mark.parametrize("several", [(), ("--drive", "pm-ac-interior")])
def test_an_option_that_changes_nothing_in_a_comparison_is_refused(refused, several: tuple[str, ...]) -> None:
    drives = (*DRIVE, *several)
    assert "--cycle has no effect" in refused("compare", "foc", *drives, "--cycle", "ece-15")
    assert "--seed has no effect" in refused("compare", "foc", *drives, "--seed", "3", "--no-checks")


def test_a_run_is_summarised_by_torque_currents_and_voltage(command, tmp_path) -> None:
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    case = tmp_path / "case.json"
    case.write_text(torque_scenario(drive, 300.0, (0.0, 5.0)).to_json(), encoding="utf-8")
    arguments = ("simulate", "foc", "--case", case, "--csv", "run.csv", "--plot", "run.svg")
    document = command(*arguments, "--json").document
    _, window = document["windows"]
    assert window["torque_reference_nm"] == 5.0
    assert window["torque_mean_nm"] == pytest.approx(5.0, rel=0.01)
    assert document["summary"]["energy_residual"] < 1e-9
    assert document["clamped"] == []
    rows = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == document["summary"]["steps"] + 1
    assert rows[0].startswith("time_s,speed_reference_rpm,")
    assert "q current at the end" in command(*arguments).out


def test_a_candidate_of_the_other_contract_is_not_simulated(refused) -> None:
    assert "takes duty ratios" in refused("simulate", "reference", "--case", "lock-up", *DRIVE)
