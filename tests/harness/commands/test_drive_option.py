"""The option --drive of every command that runs something."""

import io
import re

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.requirements import points_of
from drivegate_reports.conformance.drive import stated_values

POINT = ["--speed-rpm", "700", "--advance-deg", "30", "--current-a", "10"]
COMMANDS = {
    "check": ["initial"],
    "compare": ["initial"],
    "simulate": ["initial", "--case", "fig5-search"],
    "diff": ["initial", "initial", "--case", "fig5-search"],
    "map": ["--speed-rpm", "700", "--advance-deg", "30", "--current-a", "10"],
    "point": POINT,
    "new": ["python", "mine"],
}


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize(
    ("drive", "reason"),
    [
        ("paper-5-fase", "no drive is called 'paper-5-fase', the nearest is 'paper-5-phase'"),
        ("missing.toml", "missing.toml does not exist"),
    ],
)
def test_a_drive_that_there_is_not_is_refused(refused, name, drive, reason):
    assert reason in refused(name, *COMMANDS[name], "--drive", drive)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["check", "compare"])
def test_a_rating_that_no_controller_can_meet_is_refused_before_any_run(refused, tmp_path, name):
    weak = load_drive("paper-5-phase").replaced(name="weak", current_limit_a=20.0)
    (tmp_path / "weak.json").write_text(weak.to_json(), encoding="utf-8")
    reported = refused(name, "initial", "--drive", "weak.json", "--effort", "quick")
    assert (
        "no controller can meet what the drive 'weak' requires: 1.5 kW needs 26.0 N·m at 550 rpm" in reported
    )
    assert "a check accepts rated_power_w = 1320" in reported


def test_a_drive_of_one_s_own_is_what_a_candidate_is_made_for(command, tmp_path):
    mine = load_drive("paper-5-phase").replaced(name="mine", resistance_ohm=0.1)
    (tmp_path / "my-drive.json").write_text(mine.to_json(), encoding="utf-8")
    assert command("new", "python", "tuned", "--drive", "my-drive.json").code == 0
    manifest = (tmp_path / "tuned" / "candidate.toml").read_text(encoding="utf-8")
    assert 'drive = "drive.json"\n' in manifest
    from drivegate.candidates.resolution import resolve_candidate

    assert resolve_candidate(str(tmp_path / "tuned" / "candidate.toml")).drive == mine


def test_a_map_is_of_the_drive_that_the_candidate_s_manifest_names(command, tmp_path):
    mine = load_drive("paper-5-phase").replaced(name="mine", resistance_ohm=0.1)
    (tmp_path / "mine.json").write_text(mine.to_json(), encoding="utf-8")
    (tmp_path / "candidate.toml").write_text(
        'schema = 1\nname = "tuned"\nkind = "builtin"\nentry = "initial"\ndrive = "mine.json"\n',
        encoding="utf-8",
    )
    words = ["map", "candidate.toml", "--speed-rpm", "700", "--torque-nm", "5"]
    assert command(*words, "--json").document["drive"]["name"] == "mine"
    assert command(*words, "--drive", "paper-5-phase", "--json").document["drive"]["name"] == "paper-5-phase"


def test_a_new_drive_is_written_with_a_comment_for_each_key_and_taken_as_it_is(command, tmp_path):
    ended = command("new", "drive", "my-drive.toml", "--drive", "paper-5-phase")
    assert ended.code == 0
    assert "next: put your values into my-drive.toml, then drivegate drive my-drive.toml" in ended.out
    written, paper = load_drive(tmp_path / "my-drive.toml"), load_drive("paper-5-phase")
    assert written.name == "my-drive"
    assert (written.machine, written.inverter, written.rating) == (
        paper.machine,
        paper.inverter,
        paper.rating,
    )
    assert vars(limits_of(written)) == vars(limits_of(paper))
    assert written.provenance["machine"]["phases"] == "not stated; as in paper-5-phase, which has 5"
    command("new", "drive", "usual.toml")
    assert load_drive(tmp_path / "usual.toml").machine == load_drive("pm-ac-interior").machine
    again = command("new", "drive", "other.toml", "--drive", "my-drive.toml", "--json").document
    assert again["drive"] == load_drive(tmp_path / "other.toml").identity()


ANSWERS = "8 poles,0.5 N·m/A rms,1.2 ohm,4.4 mH,0.6 kg·cm²,2.8 A rms,8 A rms,300 V,3000 rpm,4000 rpm,,"
"""A servo motor, one answer after another; the last is left to its default."""


@pytest.fixture
def answering(monkeypatch):
    """Let a command read these answers, each of which ends with a comma."""
    return lambda answers: monkeypatch.setattr("sys.stdin", io.StringIO(answers.replace(",", "\n")))


def test_a_drive_is_made_from_a_data_sheet_and_states_each_conversion(command, answering, tmp_path):
    answering(ANSWERS)
    ended = command("new", "drive", "servo.toml", "--from-datasheet")
    assert ended.code == 0, ended.err
    assert ended.err == ""
    flux = "machine.magnet_flux_v_s = 0.058926"
    assert f"{flux}           data sheet: 0.5 N·m/A rms; Kt / (1.5 sqrt(2) pole pairs)" in ended.out
    assert ended.out.endswith("next: drivegate drive servo.toml\n")
    text = (tmp_path / "servo.toml").read_text(encoding="utf-8")
    assert re.search(r"^# rated_power_w =", text, re.MULTILINE), (
        "what follows stays so when a value is changed"
    )
    drive = load_drive(tmp_path / "servo.toml")
    assert drive.inverter.carrier_frequency_hz == 20e3
    assert 300.0 < drive.rating.rated_power_w < 500.0
    answering(ANSWERS)
    document = command("new", "drive", "other.toml", "--from-datasheet", "--json").document
    stated = {"key": "machine.pole_pairs", "value": 4, "source": "data sheet: 8 poles; pairs of poles"}
    assert stated in document["values"]


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        ("", "number of poles: there is no answer, such as '8 poles'"),
        ("7,", "'7' makes no whole number of pole pairs"),
        ("8 poles,0.5 N·m/A,", "Kv, Kt or Ke: '0.5 N·m/A' is not understood"),
        (ANSWERS.replace("4000", "2000"), "'highest_speed_rpm' is 2000, but must be above the base speed"),
    ],
)
def test_a_data_sheet_that_makes_no_drive_writes_nothing(command, answering, tmp_path, answers, words):
    answering(answers)
    ended = command("new", "drive", "servo.toml", "--from-datasheet")
    assert ended.code == 2
    assert words in ended.err
    assert len(ended.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_new_drive_keeps_no_number_that_follows_from_those_that_are_to_be_changed(command, tmp_path):
    command("new", "drive", "mine.toml", "--drive", "paper-5-phase")
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        text.replace("base_speed_rpm = 500.0", "base_speed_rpm = 3000.0")
        .replace("highest_speed_rpm = 1500.0", "highest_speed_rpm = 6000.0")
        .replace("overspeed_rpm = 2000.0", "overspeed_rpm = 8000.0"),
        encoding="utf-8",
    )
    mine = load_drive(tmp_path / "mine.toml")
    assert mine.advance is None
    assert limits_of(mine).speed_tolerance_rpm == 30.0
    assert [point.speed_rpm for point in points_of(mine)] == [6000.0]
    shown = {value.key: value.source for value in stated_values(mine)}
    assert shown["rating.base_speed_rpm"] == "not stated", "the value is no longer that of another drive"
    assert shown["machine.phases"] == "not stated; as in paper-5-phase, which has 5"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["my-drive"], "which ends in .toml"),
        (["none/my-drive.toml"], "cannot be written"),
        (["my-drive.toml", "--output", "x"], "--output goes with a candidate only"),
        (["my-drive.toml", "--drive", "none.toml"], "none.toml does not exist"),
    ],
)
def test_a_new_drive_that_cannot_be_written_is_refused(refused, words, reason):
    assert reason in refused("new", "drive", *words)


def test_a_file_that_there_is_is_never_overwritten(refused, tmp_path):
    (tmp_path / "my-drive.toml").write_text("mine", encoding="utf-8")
    assert "exists already" in refused("new", "drive", "my-drive.toml")
    assert (tmp_path / "my-drive.toml").read_text(encoding="utf-8") == "mine"
